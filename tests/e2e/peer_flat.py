#!/usr/bin/env python3
"""Real peers over a bad network for a while: what each keeps and does must not grow.

Usage: peer_flat.py PATH_TO_PADR_PEER [--seconds S] [--peers N] [--netem SPEC]

After a warm-up of 20 s (own logs are kept for 15 s) resident memory of its own, updates sent and steps replayed of the first third of
the time are held against those of the last. Exit: 0 flat, 1 not.
"""

import argparse
import re
import signal
import statistics
import sys
import time

from peers import Peer

WARM_UP = 20.0  # s
# The input is random: in half a minute rates differ by chance.
MOST_MEMORY, MOST_RATE = 1.05, 2.0  # last third by first third
STATUS = re.compile(r"status: +([\d.]+) s .* sent ([\d.]+) updates/s ([\d.]+) kbit/s .* replay ([\d.]+)/tick")


def own_kib(peer):
    """What it has allocated, as far as it is resident: of files that are mapped the system keeps as much as it likes."""
    with open(f"/proc/{peer.process.pid}/status", encoding="ascii") as file:
        return int(re.search(r"RssAnon:\s+(\d+) kB", file.read())[1])


def play(options):
    """Samples of memory, (s since the start, KiB) by peer; peers that have ended, and their exit codes."""
    common = ["--netem", options.netem, "--scenario", options.scenario, "--slots", str(options.peers)]
    peers = [Peer("--wait-peers", str(options.peers), *common)]
    try:
        port = peers[0].port()
        peers += [Peer("--join", f"127.0.0.1:{port}", *common) for _ in range(options.peers - 1)]
        for peer in peers:
            peer.wait_for(" status: ")
        begin = time.monotonic()
        memory = [[] for _ in peers]
        while time.monotonic() - begin < options.seconds:
            for peer, samples in zip(peers, memory):
                samples.append((time.monotonic() - begin, own_kib(peer)))
            time.sleep(1)
        for peer in peers:
            peer.process.send_signal(signal.SIGINT)
        return peers, memory, [peer.end() for peer in peers]
    finally:
        for peer in peers:
            peer.stop()


def thirds(samples, end):
    """Means of the first and last third of what was sampled after the warm-up."""
    length = (end - WARM_UP) / 3
    first = [v for t, v in samples if WARM_UP <= t < WARM_UP + length]
    last = [v for t, v in samples if t >= end - length]
    return statistics.fmean(first), statistics.fmean(last)


def judge(options, peers, memory):
    wrong = []
    together = {"updates": [0, 0], "traffic": [0, 0], "replay": [0, 0]}
    print("  peer   memory MiB       updates/s       kbit/s        replayed steps/tick   (first and last third)")
    for number, (peer, samples) in enumerate(zip(peers, memory)):
        rows = [[float(v) for v in m] for m in STATUS.findall(peer.text())]
        if len(rows) < options.seconds / 2:
            wrong.append(f"peer {number}: {len(rows)} status lines in {options.seconds:.0f} s")
            continue
        end = rows[-1][0]
        figures = {"memory": thirds([(t, v / 1024) for t, v in samples], options.seconds)}
        for column, name in enumerate(("updates", "traffic", "replay"), 1):
            figures[name] = thirds([(row[0], row[column]) for row in rows], end)
        print(f"  {number:4d}" + "".join(f"  {a:7.2f} {b:7.2f}" for a, b in figures.values()))
        before, after = figures["memory"]
        if after > MOST_MEMORY * before:
            wrong.append(f"peer {number}: memory grew from {before:.2f} to {after:.2f}")
        # What one player does changes from minute to minute; what all do together hardly does.
        for name in together:
            together[name] = [a + b for a, b in zip(together[name], figures[name])]
    for name, (before, after) in together.items():
        if after > MOST_RATE * max(before, 0.1):
            wrong.append(f"all together: {name} grew from {before:.2f} to {after:.2f}")
    return wrong


def main():
    parser = argparse.ArgumentParser(prog="peer_flat.py")
    parser.add_argument("--seconds", type=float, default=50)
    parser.add_argument("--peers", type=int, default=4)
    parser.add_argument("--netem", default="delay 60ms 20ms loss 2%")
    parser.add_argument("--scenario", default="arena")
    options = parser.parse_args()
    if options.seconds < WARM_UP + 9:
        parser.error(f"--seconds {options.seconds}: must be at least {WARM_UP + 9:.0f}")
    peers, memory, codes = play(options)
    wrong = judge(options, peers, memory)
    wrong += [f"peer {n} ended with {code}" for n, code in enumerate(codes) if code != 0]
    for line in wrong:
        print(f"WRONG: {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
