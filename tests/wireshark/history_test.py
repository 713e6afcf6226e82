"""Fields of one datagram that depend on others: the plugin on captures written by hand, in one pass and in two.

Usage: history_test.py
"""
import os
import struct
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "conformance"))

import pcap  # noqa: E402
import tshark  # noqa: E402
from encoder import PLACE, STATE, block, column, datagram, fixed32, number, values  # noqa: E402

NAMES = ("padr.to", "padr.resend.first", "padr.superseded.by", "padr.stale_mark", "padr.duplicate", "padr.lost",
         "padr.check_differs")  # fmt: skip
FRAMES = ("padr.resend.first", "padr.superseded.by", "padr.duplicate", "padr.check_differs")  # are numbers of frames
HELD_STATE, REST = 0x19, 0x35  # body flags: contact begin, held, with a state, at rest; at rest, with a state, released


def claim(body, epoch, age=0, back=0, index_back=0, flags=HELD_STATE):
    """An update, some ticks and numbers before the mark, in which its sender claims a body."""
    return number(1, index_back) + number(2, back) + column(4, (128 * body + flags, epoch, age)) + values((1, PLACE), (2, PLACE), (0, PLACE))


def state(peer, to, seq, tick, count, *updates, check=(0, 0), incarnation=0, session=1):
    """Of the number of a script, each with sessions and addresses of its own: a packet from that peer to that one."""
    payload = column(1, (seq, tick, count, 0, 0, 0, 0, incarnation)) + b"".join(block(9, update) for update in updates)
    payload += number(10, check[0]) + fixed32(11, check[1])

    def packet(script):
        data = datagram(STATE, payload, peer, session=10 * script + session)
        return pcap.udp(data, 45000, 45000, (10, 0, script, 1 + peer), (10, 0, script, 1 + to))

    return packet


def sealed(data, id, number, kind=STATE):
    """By a sender with this short id, readable."""
    header = data[:2] + bytes([0x94 | kind]) + data[3:6]
    return header + struct.pack("<II", id, number) + data[6:-4] + bytes(16)


def hop(sender, number, seq):
    """What peer 1, id 0x11, tells peer 2, id 0x22, as the one with the id `sender` sends it: itself, or who carries it."""
    def packet(script):
        data = datagram(STATE, column(1, (seq, 10 * seq, 0, 0, 0, 0, 0, 0)), 1, session=10 * script + 1)
        inner = sealed(data, 0x11, seq)
        whole = sealed(data[:6] + struct.pack("<I", 0x22) + inner + data[-4:], sender, number, kind=3)
        return pcap.udp(whole, 45000, 45000, (10, 0, script, sender), (10, 0, script, 9))

    return packet


def damaged(packet):
    """The same with another last byte, which is one of the tag's."""
    return lambda script: packet(script)[:-1] + bytes([packet(script)[-1] ^ 1])


# By name: packets, and what must be found besides padr.to, {(frame, field): text}. Frames count from 1 in each.
SCRIPTS = {
    "an update sent again on the same link": (
        [state(0, 1, 1, 10, 1, claim(3, 1)), state(0, 1, 2, 12, 1, claim(3, 1, back=2))], {(2, "padr.resend.first"): "1"}),
    "the same update on another link is no repeat": (
        [state(0, 1, 1, 10, 1, claim(3, 1)), state(0, 2, 1, 10, 1, claim(3, 1))], {}),
    "numbers left out": ([state(0, 1, 1, 10, 0), state(0, 1, 4, 13, 0)], {(2, "padr.lost"): "2"}),
    "late": ([state(0, 1, 1, 10, 0), state(0, 1, 3, 13, 0), state(0, 1, 2, 12, 0)],
             {(2, "padr.lost"): "1", (3, "padr.stale_mark"): "13"}),
    "twice": ([state(0, 1, 1, 10, 1, claim(3, 1))] * 2, {(2, "padr.duplicate"): "1"}),
    "carried, each hop is no duplicate of the other": (
        [hop(0x11, 1, 1), hop(0x33, 1, 1), hop(0x11, 2, 2), hop(0x33, 2, 2), hop(0x33, 2, 2)], {(5, "padr.duplicate"): "4"}),
    "another life begins anew": ([state(0, 1, 9, 90, 0), state(0, 1, 1, 95, 0, incarnation=4)], {}),
    "another session begins anew": ([state(0, 1, 9, 90, 0), state(0, 1, 1, 5, 0, session=2)], {}),
    "another hash of the same tick": (
        [state(0, 1, 1, 70, 0, check=(10, 0x111)), state(1, 0, 1, 75, 0, check=(15, 0x113)),
         state(2, 0, 1, 75, 0, check=(15, 0x111))], {(2, "padr.check_differs"): "1"}),
    # Which claim wins: WIRE.md, section 6.
    "a later epoch wins": ([state(0, 1, 1, 10, 1, claim(3, 2)), state(1, 0, 1, 11, 1, claim(3, 1, age=5))],
                           {(2, "padr.superseded.by"): "1"}),
    "a later epoch wins only from its own tick on": (
        [state(0, 1, 1, 10, 1, claim(3, 2)), state(1, 0, 1, 11, 1, claim(3, 1, back=2))], {}),
    "within a tick the lower peer comes first": (
        [state(1, 0, 1, 10, 1, claim(3, 2)), state(0, 1, 1, 10, 1, claim(3, 1))], {}),
    "in an epoch the earlier claim wins": (
        [state(0, 2, 1, 10, 1, claim(3, 1)), state(1, 2, 1, 12, 1, claim(3, 1, age=1))], {(2, "padr.superseded.by"): "1"}),
    "and the later one loses whenever it comes": (
        [state(0, 2, 1, 10, 1, claim(3, 1)), state(1, 2, 1, 12, 1, claim(3, 1, age=3))], {}),
    "in a tick the smaller lot wins: peer 1 has body 7": (
        [state(1, 2, 1, 10, 1, claim(7, 1)), state(2, 0, 1, 11, 1, claim(7, 1, age=1))], {(2, "padr.superseded.by"): "1"}),
    "and not peer 2": ([state(2, 0, 1, 10, 1, claim(7, 1)), state(1, 2, 1, 11, 1, claim(7, 1, age=1))], {}),
    "nor peer 0": ([state(0, 2, 1, 10, 1, claim(7, 1)), state(1, 2, 1, 11, 1, claim(7, 1, age=1))], {}),
    "another body is another matter": ([state(0, 1, 1, 10, 1, claim(3, 2)), state(1, 0, 1, 11, 1, claim(4, 1))], {}),
    "an owner that goes on, and releases": (
        [state(0, 1, 1, 10, 1, claim(3, 1)), state(0, 1, 2, 20, 2, claim(3, 1, age=10)),
         state(0, 1, 3, 30, 3, claim(3, 1, age=20, flags=REST))], {}),
}  # fmt: skip


# Whose address it is: not known before somebody has sent from there, in the second pass neither.
RECEIVERS = [state(0, 1, 1, 10, 0), state(1, 0, 1, 10, 0), state(0, 1, 2, 11, 0)]
# Of what cannot be read, too.
DAMAGED = [damaged(state(0, 1, 1, 10, 0)), state(1, 0, 1, 10, 0), damaged(state(0, 1, 2, 11, 0))]


def findings(path, *arguments):
    """By frame, what was found."""
    words = [word for name in NAMES for word in ("-e", name)]
    lines = tshark.run("-r", path, *arguments, "-T", "fields", *words).splitlines()
    return [{name: value for name, value in zip(NAMES, line.split("\t")) if value} for line in lines]


def check_scripts(found):
    first = 0
    for title, (packets, wanted) in SCRIPTS.items():
        wanted = {(first + frame, name): str(int(value) + first) if name in FRAMES else value
                  for (frame, name), value in wanted.items()}  # fmt: skip
        here = {(first + n, name): value for n, of_frame in enumerate(found[first:first + len(packets)], 1)
                for name, value in of_frame.items() if name != "padr.to"}  # fmt: skip
        assert here == wanted, f"{title}: {here}, not {wanted}"
        first += len(packets)
    return first


def all_packets():
    packets = [packet(n) for n, (script, _) in enumerate(SCRIPTS.values()) for packet in script]
    return packets + [packet(len(SCRIPTS)) for packet in RECEIVERS]


def main():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "script.pcap")
        pcap.write(path, all_packets() + [packet(len(SCRIPTS) + 1) for packet in DAMAGED])
        for passes in ([], ["-2"]):
            found = findings(path, *passes)
            first = check_scripts(found)
            receivers = [each.get("padr.to") for each in found[first:]]
            assert receivers == [None, "0", "1"] + [None, None, "1"], (passes, receivers)
    print(f"{len(SCRIPTS)} scripts, in one pass and in two")


if __name__ == "__main__":
    tshark.or_skip()
    main()
