#!/usr/bin/env python3
"""Real peers on a bad network for as long as one likes: nobody is lost, memory is flat, all confirmed worlds are the same.

Usage: peer_soak.py PATH_TO_PADR_PEER [--minutes M] [--peers N] [--netem SPEC] [--scenario NAME] [--plain] [--logs FOLDER]

The session has a key and is encrypted, unless --plain. A line a minute says how it goes. Every warning of every peer is
printed at the end, and with --logs the whole logs are kept. It ends early when somebody is lost.
Exit: 0 all is well, 1 not.
"""

import argparse
import os
import re
import secrets
import signal
import statistics
import sys
import tempfile
import time

from peers import Peer, checkpoints

NETEM = "delay 80ms 30ms distribution pareto loss gemodel 1% 30%"
WARM_UP = 300.0  # s; memory grows to what the busiest moments take, and is not judged in less than 4 times as long
MOST_MEMORY = 1.05  # last quarter by second quarter
LOST = re.compile(r"is lost: out|declared this peer gone|nothing has been confirmed|DIFFER|cut off")
WARNING = re.compile(r"^\S+ (warning|error|critical) ")


def own_kib(peer):
    """What it has allocated, as far as it is resident."""
    with open(f"/proc/{peer.process.pid}/status", encoding="ascii") as file:
        return int(re.search(r"RssAnon:\s+(\d+) kB", file.read())[1])


def start(options, folder):
    common = ["--netem", options.netem, "--scenario", options.scenario]
    if not options.plain:
        key = os.path.join(folder, "key")
        with open(os.open(key, os.O_WRONLY | os.O_CREAT, 0o600), "w", encoding="ascii") as file:
            file.write(secrets.token_hex(32) + "\n")
        common += ["--key-file", key, "--seal", "encrypt"]
    peers = [Peer("--wait-peers", str(options.peers), "--slots", str(options.peers + 2), *common)]
    port = peers[0].port()
    peers += [Peer("--join", f"127.0.0.1:{port}", *common) for _ in range(options.peers - 1)]
    for peer in peers:
        peer.wait_for(" status: ")
    return peers


def incidents(peers):
    """Log lines that must not be there, and processes that have ended, by peer."""
    found = []
    for number, peer in enumerate(peers):
        found += [f"peer process {number}: {line}" for line in peer.text().splitlines() if LOST.search(line)]
        if peer.process.poll() is not None:
            found.append(f"peer process {number}: has ended with {peer.process.returncode}")
    return found


def watch(peers, minutes):
    """Samples of memory, (s, KiB) by peer; ends early if something is wrong already."""
    begin = time.monotonic()
    memory = [[] for _ in peers]
    told = 0.0
    while (now := time.monotonic() - begin) < 60 * minutes:
        for peer, samples in zip(peers, memory):
            if peer.process.poll() is None:
                samples.append((now, own_kib(peer)))
        wrong = incidents(peers)
        if wrong or now - told >= 60:
            told = now
            kib = " ".join(f"{samples[-1][1] / 1024:.1f}" for samples in memory)
            print(f"{now / 60:6.1f} min: memory {kib} MiB, {len(wrong)} incidents", flush=True)
        if wrong:
            break
        time.sleep(2)
    return memory


def judge_memory(memory, minutes):
    end = 60 * minutes
    if end < 4 * WARM_UP:
        return []
    wrong = []
    quarter = (end - WARM_UP) / 4
    for number, samples in enumerate(memory):
        early = [kib for at, kib in samples if WARM_UP + quarter <= at < WARM_UP + 2 * quarter]
        late = [kib for at, kib in samples if at >= end - quarter]
        if not early or not late:
            continue
        before, after = statistics.fmean(early), statistics.fmean(late)
        print(f"peer process {number}: memory {before / 1024:.2f} MiB, at the end {after / 1024:.2f} MiB")
        if after > MOST_MEMORY * before:
            wrong.append(f"peer process {number}: memory grew from {before:.0f} to {after:.0f} KiB")
    return wrong


def judge_worlds(peers):
    wrong = []
    summaries = [peer.summary() for peer in peers]
    points = [checkpoints(summary) for summary in summaries]
    common = sorted(set(points[0]).intersection(*points[1:]), key=int)
    differ = [tick for tick in common if len({p[tick] for p in points}) > 1]
    print(f"confirmed worlds: {len(common)} checkpoints of all peers, {len(differ)} differ")
    if differ:
        wrong.append(f"confirmed worlds differ at ticks {differ[:5]}")
    if not common:
        wrong.append("no checkpoint is common to all peers")
    for number, summary in enumerate(summaries):
        if len(summary["lives"]) != 1:
            wrong.append(f"peer process {number}: {len(summary['lives'])} lives")
        if summary["confirmed"]["mismatches"]:
            wrong.append(f"peer process {number}: {summary['confirmed']['mismatches']} hashes of others differ")
    return wrong


def keep_logs(peers, folder):
    os.makedirs(folder, exist_ok=True)
    for number, peer in enumerate(peers):
        with open(os.path.join(folder, f"peer{number}.log"), "w", encoding="utf-8") as file:
            file.write(peer.text() + "\n")


def soak(options, folder):
    peers = start(options, folder)
    try:
        memory = watch(peers, options.minutes)
        wrong = incidents(peers)
        for peer in peers:
            if peer.process.poll() is None:
                peer.process.send_signal(signal.SIGINT)
        codes = [peer.end() for peer in peers]
        if any(codes):
            wrong.append(f"exit codes {codes}")
        else:
            wrong += judge_worlds(peers)
        wrong += judge_memory(memory, options.minutes)
        for number, peer in enumerate(peers):
            for line in peer.text().splitlines():
                if WARNING.search(line):
                    print(f"peer process {number}: {line}")
        return wrong
    finally:
        if options.logs:
            keep_logs(peers, options.logs)
        for peer in peers:
            peer.stop()


def main():
    parser = argparse.ArgumentParser(prog="peer_soak.py")
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--peers", type=int, default=4)
    parser.add_argument("--netem", default=NETEM)
    parser.add_argument("--scenario", default="clutter")
    parser.add_argument("--plain", action="store_true", help="without a key")
    parser.add_argument("--logs", help="folder for the peers' logs")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        wrong = soak(options, folder)
    print("\n".join(wrong) if wrong else "all is well")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
