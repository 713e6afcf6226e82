"""tshark with the plugin against the second decoder, without a network: the test vectors, messages of every kind drawn at
random, damaged ones, what a capture has cut off, and other protocols' datagrams.

Usage: datagrams_test.py WIRE_SAMPLES WIRE_MD
"""
import os
import random
import re
import struct
import subprocess
import sys
import tempfile
from collections import Counter

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "conformance"))

import pcap  # noqa: E402
import tshark  # noqa: E402
from encoder import tagged  # noqa: E402
from expected import fields, has_crc, is_claimed, is_sealed  # noqa: E402
from limits import cases  # noqa: E402
from others import packets  # noqa: E402
from sealed import AUTH, ENCRYPT, sealed  # noqa: E402
from sealed import vectors as sealed_vectors  # noqa: E402

COUNT = 400  # that the samples' program draws, of each of which there is a damaged copy
SEAL_KEY, SEAL_ID = bytes(range(32)), bytes(range(100, 132))
OTHERS = 150  # of each sort of other traffic


def vectors(path):
    with open(path, encoding="utf-8") as file:
        blocks = re.findall(r"^```(?:hex|bytes)\n([^`]*)```", file.read(), re.M)
    bare = [re.sub(r"#.*", "", block) for block in blocks]
    return [bytes.fromhex(re.sub(r"(\w\w)\*(\d+)", lambda found: found[1] * int(found[2]), each)) for each in bare]


def samples(program):
    output = subprocess.run([program, str(COUNT)], stdout=subprocess.PIPE, check=True, text=True).stdout
    return [bytes.fromhex(line.split(" ")[1]) for line in output.splitlines() if line.startswith("datagram ")]


def damaged(datagrams, rng):
    """Of each: cut off, a bit flipped, a byte changed under a tag that fits, another version, another kind, too long."""
    for datagram in datagrams:
        yield datagram[:rng.randrange(len(datagram))]
        at = rng.randrange(len(datagram))
        flipped = datagram[:at] + bytes([datagram[at] ^ 1 << rng.randrange(8)]) + datagram[at + 1:]
        yield flipped
        yield tagged(flipped[:-4])
        yield tagged(datagram[:2] + bytes([0x50 | datagram[2] & 15]) + datagram[3:-4])
        yield tagged(datagram[:2] + bytes([0x3F]) + datagram[3:-4])
        yield tagged(datagram[:-4] + bytes(1200))


def check(path, datagrams, *arguments):
    """All that tshark shows of these is what the second decoder reads; gives what came of them, and the number of values."""
    outcomes, values = Counter(), 0
    pcap.write(path, [pcap.udp(datagram) for datagram in datagrams])
    shown_of_all = tshark.frames(path, *arguments)
    for n, (datagram, shown) in enumerate(zip(datagrams, shown_of_all, strict=True)):
        if shown is None or not is_claimed(datagram):
            if (shown is None) == is_claimed(datagram):
                raise tshark.Mismatch(f"claimed or not, wrongly: {datagram.hex(' ')}: {shown}")
            outcomes["not claimed"] += 1
            continue
        wanted = fields(datagram)
        values += tshark.compare(datagram.hex(" "), wanted, shown)
        outcomes[dict(wanted).get("padr.drop", "read")] += 1
    return outcomes, values


def check_cut_off(path, datagrams):
    """A capture of the first bytes only: the envelope as far as it is there, no verdict on the tag, and nothing breaks."""
    pcap.write(path, [pcap.udp(datagram) for datagram in datagrams], snaplen=14 + 28 + 20)
    for datagram, shown in zip(datagrams, tshark.frames(path), strict=True):
        whole = len(datagram) <= 20
        wanted = fields(datagram) if whole else fields(datagram)[:4]
        if is_claimed(datagram) and datagram[2] in (0x90, 0x91, 0x92) and len(datagram) <= 1200:
            tshark.compare(f"cut off: {datagram.hex(' ')}", wanted, shown)


def check_keylog(path, datagrams, rng):
    """With the key, both sorts are read alike, over the carry of the numbers; and damage is told."""
    keylog = path + ".keys"
    with open(keylog, "w", encoding="utf-8") as file:
        for key in (bytes(32), SEAL_KEY):
            file.write(f"padr-key {SEAL_ID.hex()} {bytes(32).hex()} {key.hex()}\n")
    first = 2**32 - len(datagrams) // 2
    sent, opened = [], []
    for n, datagram in enumerate(datagrams):
        data, plain = sealed(SEAL_KEY, (AUTH, ENCRYPT)[n % 2], SEAL_ID, first + n, datagram), datagram
        if n % 7 == 6:
            at = rng.randrange(14, len(data))
            data, plain = data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1:], False
        sent.append(data)
        opened.append(plain)
    pcap.write(path, [pcap.udp(data) for data in sent])
    values = 0
    for data, plain, shown in zip(sent, opened, tshark.frames(path, "-o", f"padr.keylog:{keylog}"), strict=True):
        values += tshark.compare(data.hex(" "), fields(data, plain), shown)
    print(f"with the key: {len(sent)} datagrams, {values} values as the second decoder has them")
    folder = os.path.dirname(path)
    for text, bad, said in (("padr-key 12\n", path + ".bad", "line 1 of"), (None, path + ".bad", "No such file"),
                            (None, folder, f"PADR's key log: {folder}: Is a directory")):  # fmt: skip
        if text:
            with open(bad, "w", encoding="utf-8") as file:
                file.write(text)
        words = tshark.command("-r", path, "-o", f"padr.keylog:{bad}")
        done = subprocess.run(words, capture_output=True, text=True, check=False, env=tshark.environment())
        assert said in done.stderr and "Lua" not in done.stderr, done.stderr
        if text:
            os.remove(bad)


def check_in_icmp(path, datagram):
    """What comes back in an error message is shown, but is no second datagram."""
    packet = pcap.udp(datagram)
    pcap.write(path, [packet, pcap.icmp_unreachable(packet), packet])
    duplicates = tshark.run("-r", path, "-Y", "padr.duplicate", "-T", "fields", "-e", "frame.number").split()
    assert duplicates == ["3"], duplicates


def check_decode_as(path, datagram):
    """Who says that a port is ours gets everything on it explained, if only that it is none of ours."""
    pcap.write(path, [pcap.udp(data) for data in (datagram, b"Px" + datagram[2:], b"Pd", b"")])
    drops = tshark.run("-r", path, "-d", "udp.port==40002,padr", "-T", "fields", "-e", "padr.peer", "-e", "padr.drop")
    assert drops.splitlines() == [f"{datagram[3]}\t", f"{datagram[3]}\tmagic", "\t", "\t"], drops


def check_ports_of_afs(path, datagrams):
    """Without any option: what is ours there is shown as ours, and what is AFS's as AFS's."""
    rx = struct.pack(">IIIIIBBBBHH", 1, 4, 1, 1, 1, 2, 4, 0, 0, 0, 1) + bytes(8)  # an acknowledgement
    sent = [(data, port) for port in (7000, 7001, 7009) for data in [*datagrams, rx]]
    pcap.write(path, [pcap.udp(data, 40002, port) for data, port in sent])
    shown = tshark.output(["tshark", "-n", "-X", f"lua_script:{tshark.PLUGIN}", "-r", path, "-T", "fields", "-e", "padr.version", "-e", "rx.type"],
                          tshark.environment()).splitlines()  # fmt: skip
    for (data, port), line in zip(sent, shown, strict=True):
        ours, theirs = (cell != "" for cell in line.split("\t"))
        assert (ours, theirs) == (data != rx, data == rx), (port, data, line)


def check_others(path):
    sent = packets(OTHERS, seed=4)
    pcap.write(path, sent)
    claimed = tshark.run("-r", path, "-Y", "padr", "-T", "fields", "-e", "frame.number").split()
    assert not claimed, f"other traffic is claimed: frames {claimed}"
    return len(sent)


def main(program, vectors_md):
    rng = random.Random(9)
    written = [datagram for datagram in vectors(vectors_md) if datagram]
    drawn = samples(program)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "samples.pcap")
        parts = {"vectors": written, "limits": list(cases()), "samples": drawn}
        parts["sealed"] = [each for datagram in written + drawn if len(datagram) >= 10 and is_claimed(datagram)
                           for each in (sealed(SEAL_KEY, AUTH, SEAL_ID, 7, datagram), sealed(SEAL_KEY, ENCRYPT, SEAL_ID, 8, datagram))
                           if is_sealed(each)] + [each for each in sealed_vectors().values() if each[:2] == b"Pd"]  # fmt: skip
        parts["damaged"] = list(damaged(written + drawn[::4], rng))
        for what, datagrams in parts.items():
            outcomes, values = check(path, datagrams)
            print(f"{what}: {len(datagrams)} datagrams, {values} values as the second decoder has them; {dict(outcomes)}")
            assert outcomes["read"] > 20 and outcomes["malformed"] > 5 - 5 * (what == "sealed"), outcomes
        check(path, written + drawn[:200], "-2", "-R", "frame")
        check_cut_off(path, written + drawn)
        undamaged = [each for each in written + drawn if len(each) >= 10 and has_crc(each)]
        check_keylog(path, [each for each in undamaged if is_claimed(sealed(SEAL_KEY, AUTH, SEAL_ID, 1, each))], rng)
        good = next(datagram for datagram in drawn if dict(fields(datagram)).get("padr.seq"))
        check_in_icmp(path, good)
        check_decode_as(path, good)
        check_ports_of_afs(path, [each for each in drawn if is_claimed(each)])
        print(f"none of {check_others(path)} datagrams of other protocols is claimed")


if __name__ == "__main__":
    tshark.or_skip()
    main(*sys.argv[1:])
