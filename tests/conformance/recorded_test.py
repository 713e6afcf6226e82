"""The second decoder reads all that real peers send one another through a bad network, and what it reads makes sense.

The relay in between also delivers damaged copies of what it passes on: whatever the decoder drops the peers must drop too,
and for the same reason, by the counts of their summaries.

Usage: recorded_test.py PADR_PEER
"""
import json
import os
import random
import re
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter

from decoder import STATE, decode
from relay import FOUNDER, Relay
from rules import Drop
from session import Session

PEERS = 3
SECONDS = 6
DAMAGED = 0.5  # so many of the datagrams of play get a damaged companion, if it would be dropped
FLAGS = ["--scenario", "arena", "--seed", "5", "--input", "wander", "--duration", str(SECONDS), "--linger", "8",
         "--threshold", "0.2:0.05", "--body-threshold", "0.03", "--status-interval", "0"]  # fmt: skip


class Damage:
    """Damaged copies of datagrams, and how often each receiver must count which reason."""

    def __init__(self):
        self.random = random.Random(7)
        self.expected = [Counter() for _ in range(PEERS)]

    def companions(self, receiver, datagram):
        """At most one; its tag fits unless that is what is wrong with it."""
        if self.random.random() > DAMAGED:
            return []
        at, bit = self.random.randrange(6, len(datagram) - 4), self.random.randrange(8)
        damaged = datagram[:at] + bytes([datagram[at] ^ 1 << bit]) + datagram[at + 1:-4]
        tag = zlib.crc32(damaged) ^ (self.random.random() < 0.2)
        damaged += struct.pack("<I", tag)
        try:
            decode(damaged)
        except Drop as drop:
            self.expected[receiver][drop.reason] += 1
            return [damaged]
        return []  # it would be believed


class Recording:
    def __init__(self):
        self.session, self.damage = Session(PEERS), Damage()
        self.numbered = {FOUNDER}  # the peers that have used their number
        self.in_play = set()  # those that have sent a state datagram
        self.since = None  # the tick from which on all are in play

    def __call__(self, sender, receiver, datagram):
        decoded = self.session.datagram(sender, receiver, datagram)
        self.numbered.add(decoded["sender"])
        if decoded["kind"] != STATE:
            return []
        self.in_play.add(sender)
        if self.since is None and len(self.in_play) == PEERS:
            self.since = decoded["mark_tick"]
        # Not near the ends of play, where a receiver may not listen yet or any more.
        if self.since is None or not 0 <= decoded["mark_tick"] - self.since <= 60 * (SECONDS - 1):
            return []
        return self.damage.companions(receiver, datagram)

    def welcomed(self, number):
        return number in self.numbered


def start(peer, folder, number, flags):
    log = open(os.path.join(folder, f"{number}.log"), "w")
    summary = os.path.join(folder, f"{number}.json")
    return subprocess.Popen([peer, *flags, *FLAGS, "--json", summary], stderr=log)


def founder_address(folder, process):
    while process.poll() is None:
        with open(os.path.join(folder, f"{FOUNDER}.log")) as log:
            found = re.search(r"listening on 127\.0\.0\.1:(\d+)", log.read())
        if found:
            return "127.0.0.1", int(found.group(1))
        time.sleep(0.02)
    raise AssertionError("the founder ended at once")


def play(peer, folder):
    """Peers one after another, so that their numbers are those of the relay; gives the recording and the summaries."""
    recording = Recording()
    processes = [start(peer, folder, FOUNDER, ["--listen", "127.0.0.1:0", "--wait-peers", str(PEERS)])]
    relay = Relay(founder_address(folder, processes[0]), PEERS, recording)
    try:
        for number in range(1, PEERS):
            processes.append(start(peer, folder, number, ["--join", f"127.0.0.1:{relay.port(FOUNDER)}"]))
            relay.run_while(lambda: not recording.welcomed(number) and processes[-1].poll() is None)
        relay.run_while(lambda: any(process.poll() is None for process in processes))
    finally:
        relay.close()
        for process in processes:
            process.kill()
    for number, process in enumerate(processes):
        with open(os.path.join(folder, f"{number}.log")) as log:
            assert process.wait() == 0, log.read()
    return recording, [json.load(open(os.path.join(folder, f"{n}.json"))) for n in range(PEERS)]


def compare(recording, number, summary):
    """What the decoder has counted with what the peer says of itself."""
    session, expected, dropped = recording.session, recording.damage.expected[number], summary["dropped"]
    sent = sum(link.datagrams for (sender, _), link in session.links.items() if sender == number)
    print(f"peer {number}: {sent} state datagrams, {len(session.updates[number])} updates; to be dropped: {dict(expected)}")
    assert summary["sent"]["datagrams"] == sent, summary["sent"]
    assert summary["sent"]["bundles"] == len(session.updates[number]), summary["sent"]
    assert summary["confirmed"]["mismatches"] == 0, summary["confirmed"]
    assert summary["session"]["datagrams"]["seal"] == expected["tag"], summary["session"]
    assert dropped["malformed"] == expected["malformed"] and dropped["foreign"] == 0, dropped
    # What of these comes first may hang on the scenario and the clock, which the decoder does not know.
    unbelieved = ("tick", "order", "entity", "value")
    assert sum(dropped[reason] for reason in unbelieved) == sum(expected[reason] for reason in unbelieved), dropped


def check_plenty(session, damaged):
    """All of the above would hold of a session in which nothing happens, too."""
    state = sum(link.datagrams for link in session.links.values())
    updates = sum(len(updates) for updates in session.updates)
    print(f"{state} state datagrams, {session.marks} of them marks, {updates} updates, {session.bodies} bodies in them,"
          f" the longest of {session.longest} bytes; session messages: {session.messages}")  # fmt: skip
    assert state >= 200 and session.marks >= 50 and updates >= 60 and session.bodies >= 30
    assert all(sum(expected.values()) >= 5 for expected in damaged), damaged
    assert {"join", "welcome", "ping", "pong", "pull", "piece", "enter"} <= set(session.messages)


def main(peer):
    with tempfile.TemporaryDirectory() as folder:
        recording, summaries = play(peer, folder)
    recording.session.finish()
    check_plenty(recording.session, recording.damage.expected)
    for number, summary in enumerate(summaries):
        compare(recording, number, summary)


main(*sys.argv[1:])
