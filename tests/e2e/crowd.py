#!/usr/bin/env python3
"""Many padr-peer processes: every few seconds one is killed and another one started; then their confirmed worlds are compared.

Usage: crowd.py PATH_TO_PADR_PEER [--seconds S] [--peers N] [--netem SPEC] [--kill-every S] [--seed N] [--scenario NAME]

tools/chaos.sh builds and runs this. Exit status: 0 if all that had to agree did, 1 if not, 2 for wrong arguments.
"""

import argparse
import random
import re
import signal
import sys
import time

from peers import PLAYING, Peer, checkpoints, differing

SETTLE = 6.0  # s after the last kill: whoever was killed is out by then, and confirmed has caught up


class Crowd:
    def __init__(self, options, say=print):
        self.options = options
        self.say = say
        self.rng = random.Random(options.seed)
        self.peers = []  # all that ever were, by the order they came
        self.alive = []
        self.troubles = []
        self.join_s = {}  # by number: from starting the process to its log saying that it plays

    def start(self, *role):
        o = self.options
        number = len(self.peers)
        peer = Peer("--listen", "127.0.0.1:0", "--scenario", o.scenario, "--netem", o.netem, "--netem-seed",
                    o.seed * 1000 + number, "--input", f"wander:{number}", *role)  # fmt: skip
        peer.number = number
        peer.born = time.monotonic()
        self.peers.append(peer)
        self.alive.append(peer)
        return peer

    def found(self):
        founder = self.start("--wait-peers", self.options.peers)
        port = founder.port()
        for _ in range(1, self.options.peers):
            self.start("--join", f"127.0.0.1:{port}")
        for peer in self.alive:
            peer.wait_for(PLAYING)
        founder.wait_for(r" status: ")

    def drop_ended(self):
        for peer in [p for p in self.alive if p.process.poll() is not None]:
            self.alive.remove(peer)
            self.troubles.append(f"process {peer.number} ended by itself with {peer.process.returncode}: {peer.log[-1:]}")

    def playing(self):
        return [p for p in self.alive if re.search(PLAYING, p.text())]

    def kill_one_and_start_another(self):
        self.drop_ended()
        able = self.playing()
        if len(able) < 2:
            self.troubles.append("fewer than two peers play")
            return
        victim = self.rng.choice(able)
        self.alive.remove(victim)
        victim.process.kill()
        by = self.rng.choice([p for p in able if p is not victim])
        peer = self.start("--join", f"127.0.0.1:{by.port()}")
        self.say(f"  killed process {victim.number}, started {peer.number}, which joins by {by.number}")

    def wait_until(self, deadline):
        """Notes meanwhile how long newcomers take."""
        while time.monotonic() < deadline:
            for peer in self.alive:
                if peer.number >= self.options.peers and peer.number not in self.join_s:
                    if re.search(PLAYING, peer.text()):
                        self.join_s[peer.number] = time.monotonic() - peer.born
            time.sleep(0.02)

    def play(self):
        o = self.options
        start = time.monotonic()
        next_kill = start + o.kill_every
        while next_kill + SETTLE < start + o.seconds:
            self.wait_until(next_kill)
            self.kill_one_and_start_another()
            next_kill += o.kill_every
        self.wait_until(start + max(o.seconds, SETTLE))
        self.drop_ended()
        for peer in self.alive:
            if not re.search(PLAYING, peer.text()):
                self.troubles.append(f"process {peer.number} did not come in: {peer.log[-1:]}")

    def end(self):
        """Everybody says goodbye; the survivors' summaries."""
        for peer in self.alive:
            peer.process.send_signal(signal.SIGINT)
        for peer in self.alive:
            code = peer.end()
            if code != 0:
                self.troubles.append(f"process {peer.number} ended with {code}: {peer.log[-1:]}")
        return {p.number: p.summary() for p in self.alive if p.process.returncode == 0}

    def stop(self):
        for peer in self.peers:
            peer.stop()


def lags(peer):
    """How far confirmed trailed, ms, by the status lines."""
    return [int(m) for m in re.findall(r"confirmed -(\d+) ms", peer.text())]


def table(crowd, summaries):
    yield "  process  slot  lives  came s  join ms  late ticks  stalls > 2 ticks  longest ms  lag median/worst ms  others lost"
    for number, s in sorted(summaries.items()):
        lag = sorted(lags(crowd.peers[number])) or [0]
        yield (f"  {number:7d}  {s['peer']:4d}  {len(s['lives']):5d}  {s['first_tick'] / 60:6.1f}  {s['join_ms']:7.0f}"
               f"  {s['late_ticks']:10d}  {s['stalls']:16d}  {s['longest_stall_ms']:10.1f}"
               f"  {lag[len(lag) // 2]:9d} / {lag[-1]:7d}  {s['others']['removed']:11d}")  # fmt: skip


def judge(crowd, summaries):
    """Prints what there is to say; whether all is well."""
    shared, differ = differing(summaries.values())
    for line in table(crowd, summaries):
        crowd.say(line)
    joins = sorted(crowd.join_s.values())
    if joins:
        within = sum(1 for j in joins if j <= 1.0)
        crowd.say(f"newcomers: {len(joins)}, from starting the process to playing: median {joins[len(joins) // 2]:.2f} s, "
                  f"worst {joins[-1]:.2f} s, {within} within 1 s")  # fmt: skip
    if len(summaries) < 2 or shared == 0:
        crowd.troubles.append("there is nothing to compare")
    for tick in differ[:3]:
        who = {n: checkpoints(s).get(str(tick)) for n, s in summaries.items()}
        crowd.troubles.append(f"confirmed hashes differ at tick {tick}: {who}")
    for number, s in summaries.items():
        if s["confirmed"]["mismatches"] > 0:
            crowd.troubles.append(f"process {number} counted {s['confirmed']['mismatches']} differing hashes")
    for trouble in crowd.troubles:
        crowd.say(f"WRONG: {trouble}")
    crowd.say(f"confirmed hashes of survivors: {shared} whole seconds compared, {len(differ)} differ; "
              f"{len(crowd.peers)} processes in all, {len(summaries)} survived")  # fmt: skip
    return not crowd.troubles


def play(options, say=print):
    crowd = Crowd(options, say)
    well = False
    try:
        crowd.found()
        crowd.play()
        well = judge(crowd, crowd.end())
        return well
    finally:
        crowd.stop()
        if not well:
            for peer in crowd.peers:
                print(f"--- log of process {peer.number}, exit {peer.process.returncode}\n{peer.text()}", file=sys.stderr)


def parse(arguments):
    p = argparse.ArgumentParser(prog="crowd.py")
    p.add_argument("--seconds", type=float, default=30)
    p.add_argument("--peers", type=int, default=10)
    p.add_argument("--netem", default="delay 60ms 20ms loss 2%")
    p.add_argument("--kill-every", type=float, default=5)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--scenario", default="arena")
    return p.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(0 if play(parse(sys.argv[1:])) else 1)
