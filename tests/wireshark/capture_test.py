"""tshark with the plugin against the second decoder: every field of what real peers have sent one another.

Usage: capture_test.py PADR_PEER [--datagrams N] [--capture FILE] [--keep FILE] [--exporter CMD]
"""
import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections import Counter

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "..", "conformance"), os.path.join(HERE, "..", "e2e")]

import pcap  # noqa: E402
import play  # noqa: E402
import tshark  # noqa: E402
from decoder import decode  # noqa: E402
from expected import fields, is_claimed, is_handshake, is_sealed, of_transfer  # noqa: E402

MANY = 20000  # datagrams from which on more peers play, most of them telling everything at every tick
# What must be in a capture of the session that is played; a fetch happens only if the founder lacks what others have.
EVERY = {"state", "join", "welcome", "redirect", "refuse", "ping", "pong", "pull", "piece", "enter",
         "poll", "answer", "update", "avatar", "body", "admission", "removal", "leave", "transfer"}  # fmt: skip


class Seen:
    """What has been in the capture, so that agreement on nothing is no success."""

    def __init__(self):
        self.kinds, self.drops, self.values, self.frames, self.pieces, self.transfers = Counter(), Counter(), 0, 0, {}, 0

    def add(self, datagram, wanted):
        self.frames += 1
        found = dict(wanted)
        if "padr.drop" in found:
            self.drops[found["padr.drop"]] += 1
            return
        self.kinds[found.get("padr.message", "state")] += 1
        for name in ("update", "avatar", "body", "admission", "removal", "passed_on"):
            self.kinds[name] += f"padr.{name}" in found
        self.kinds["leave"] += "padr.update.leave" in found

    def transfer(self, datagram):
        """The fields of a transfer that this datagram completes; none otherwise."""
        if is_sealed(datagram) or is_handshake(datagram):
            return []  # what nobody has sent in this session: the network has damaged the kind
        decoded = decode(datagram)
        name, piece = decoded.get("message", (None, None))
        if name != "piece":
            return []
        pieces = self.pieces.setdefault(piece["nonce"], {})
        if len(pieces) == piece["count"]:
            return []
        pieces[piece["index"]] = piece["bytes"]
        if len(pieces) < piece["count"]:
            return []
        self.kinds["transfer"] += 1
        return list(of_transfer(b"".join(pieces[n] for n in range(piece["count"]))))


def compare(path, *arguments):
    seen = Seen()
    for datagram, shown in zip(pcap.read(path), tshark.frames(path, *arguments), strict=True):
        if datagram is None or not is_claimed(datagram):
            if shown is not None:
                raise tshark.Mismatch(f"claimed, but not ours: {datagram}")
            seen.drops["not claimed"] += 1  # what the network has damaged so that nothing tells it is ours
            continue
        where = f"frame {seen.frames + 1}: {datagram.hex(' ')}"
        if shown is None:
            raise tshark.Mismatch(f"not claimed: {where}")
        wanted = fields(datagram)
        seen.add(datagram, wanted)
        if "padr.drop" not in dict(wanted):
            wanted += seen.transfer(datagram)
        seen.values += tshark.compare(where, wanted, shown)
    return seen


def exported(path, exporter):
    """What `CMD FILE` prints: one JSON object a line, a list under a name that comes more than once."""
    with subprocess.Popen([*shlex.split(exporter), path], stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            yield json.loads(line)
    assert process.returncode == 0, exporter


def compare_export(path, exporter):
    """An exporter of the same names: by name, the values in the order of the datagram."""
    ours, count = (datagram for datagram in pcap.read(path) if datagram is not None and is_claimed(datagram)), 0
    for datagram, record in zip(ours, exported(path, exporter), strict=True):
        wanted = {}
        for name, value in fields(datagram):
            if value is not None:
                wanted.setdefault(name, []).append(value)
        for name, values in wanted.items():
            shown = record.get(name)
            shown = shown if isinstance(shown, list) else [shown]
            if len(shown) != len(values) or not all(map(same_exported, values, shown)):
                raise tshark.Mismatch(f"{datagram.hex(' ')}: {name} should be {values}, the exporter has {shown}")
            count += len(values)
    return count


ENUMS = ("state session membership", "threshold contact_begin contact_end proxy body_threshold at_rest leave",
         "static first second input")  # fmt: skip


def same_exported(value, shown):
    """Names stand for the numbers of enumerations, hexadecimal digits for numbers that are not counted with."""
    if isinstance(shown, str) and isinstance(value, int) and not isinstance(value, bool):
        if any(shown in names.split() for names in ENUMS):
            return any(shown in names.split() and names.split().index(shown) == value for names in ENUMS)
        return len(shown) in (8, 16) and int(shown, 16) == value
    if isinstance(value, bool) or isinstance(shown, bool):
        return value is shown
    return tshark.is_same(value, str(shown))


def check_passes_agree(path):
    """What is found out from other datagrams is the same in one pass and in two, and not nothing."""
    names = [name for name in tshark.CONTEXT if name != "padr.to"]  # whom a datagram goes to may become known later only
    arguments = ["-r", path, "-T", "fields", *(word for name in names for word in ("-e", name))]
    once, twice = tshark.run(*arguments), tshark.run("-2", *arguments)
    assert once == twice, "two passes find something else than one"
    found = Counter(name for line in once.splitlines() for name, value in zip(names, line.split("\t")) if value)
    assert all(found[name] for name in ("padr.resend", "padr.stale_mark", "padr.duplicate", "padr.lost")), found
    assert not found["padr.check_differs"], found
    return found


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--datagrams", type=int, default=2000, help="to capture, about [%(default)s]")
    parser.add_argument("--capture", help="compare this capture (tcpdump's, of Ethernet) instead of playing")
    parser.add_argument("--keep", help="where to leave the capture")
    parser.add_argument("--exporter", help="compare also what this command prints of the capture: a JSON object a line")
    return parser.parse_args(arguments)


def main(options):
    tshark.or_skip("tcpdump")
    with tempfile.TemporaryDirectory() as folder:
        path = options.capture or options.keep or os.path.join(folder, "padr.pcap")
        if not options.capture:
            many = options.datagrams >= MANY
            try:
                lost = play.record(path, options.datagrams, members=8 if many else 4, chatty=5 if many else 1)
            except play.NotPermitted as reason:
                print(f"skipped: capturing is not permitted here: {reason}")
                return tshark.SKIPPED
            print(f"tcpdump has lost {lost} frames")
        started = time.monotonic()
        seen = compare(path)
        took = time.monotonic() - started
        print(f"{seen.frames} datagrams in {took:.1f} s, {seen.values} values as the second decoder has them\n"
              f"  with {dict(seen.kinds)}\n  dropped by everybody: {dict(seen.drops)}")  # fmt: skip
        print(f"found out from other datagrams: {dict(check_passes_agree(path))}")
        if options.exporter:
            print(f"exporter: {compare_export(path, options.exporter)} values the same")
        if not options.capture:
            assert EVERY <= {kind for kind, count in seen.kinds.items() if count}, EVERY - set(seen.kinds)
            assert seen.frames >= options.datagrams and seen.drops["tag"] > 0, seen.drops
    return 0


sys.exit(main(parse(sys.argv[1:])))
