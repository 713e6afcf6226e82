"""A flood of garbage at one of four peers: nobody drops out, nothing of it is taken in, and confirmed worlds agree.

Usage: peer_flood.py PADR_PEER FLOOD [--rate N] [--seconds N] [--calm N]: garbage datagrams a second, for how long, and how
long the same session plays without before. Prints how late ticks began, with and without; no test asserts a time.
"""

import os
import subprocess
import sys

FLOOD = sys.argv.pop(2)


def number(flag, otherwise):
    if flag not in sys.argv:
        return otherwise
    at = sys.argv.index(flag)
    value = int(sys.argv[at + 1])
    del sys.argv[at:at + 2]
    return value


RATE, SECONDS, CALM = number("--rate", 20_000), number("--seconds", 5), number("--calm", 5)

from peers import PLAYING, Case, main, time  # noqa: E402

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "conformance"))

import protobuf  # noqa: E402

KEY = "33" * 32
COUNT = 4
FLOODED = 1
TICKS_PER_SECOND = 60
STEP, STEP_TICK, STEP_LATENESS = 2, 1, 8  # fields of proto/trace.proto


def lateness(path):
    """Of every tick of a trace: the tick, and by how many milliseconds it began late."""
    with open(path, "rb") as f:
        data = f.read()
    at = 8  # behind magic and version
    found = []
    while at < len(data):
        size, at = protobuf.varint(data, at)
        record, at = protobuf.take(data, at, size)
        for kind, _, value in protobuf.fields(record):
            if kind != STEP:
                continue
            of = {n: v for n, _, v in protobuf.fields(value) if n in (STEP_TICK, STEP_LATENESS)}
            zigzag = of.get(STEP_LATENESS, 0)
            found.append((of.get(STEP_TICK, 0), ((zigzag >> 1) ^ -(zigzag & 1)) / 1000))
    return found


def percentile(values, p):
    return sorted(values)[min(len(values) - 1, int(len(values) * p / 100))]


class Flood(Case):
    def play(self, env, more):
        traces = [os.path.join(self.folder.name, f"peer{i}.trace") for i in range(COUNT)]
        own = [["--duration", CALM + SECONDS + 60, "--trace", traces[i], *more(i)] for i in range(COUNT)]
        founder = self.peer("--wait-peers", COUNT, *own[0], env=env)
        peers = [founder] + [self.peer("--join", f"127.0.0.1:{founder.port()}", *own[i], env=env)
                             for i in range(1, COUNT)]  # fmt: skip
        for p in peers:
            p.wait_for(PLAYING)
        time.sleep(CALM)  # that is how long it is to play, not a wait for something to have happened
        return peers, traces

    def flood(self, peers, seed, ids):
        began = time.monotonic()
        done = subprocess.run([FLOOD, str(peers[FLOODED].port()), str(RATE), str(SECONDS), str(seed), *ids],
                              stdout=subprocess.PIPE, text=True, check=True)  # fmt: skip
        print(f"  flood: {done.stdout.strip()}, {time.monotonic() - began:.1f} s", file=sys.stderr)

    def check(self, peers, traces):
        for p in peers:
            p.process.terminate()
        for p in peers:
            self.assertEqual(p.end(), 0, p.text())
        self.check_agreement(peers, 5)
        for p in peers:
            summary = p.summary()
            self.assertEqual(summary["others"]["removed"], 0, p.text())
            self.assertEqual(len(summary["lives"]), 1, p.text())
        for i, trace in enumerate(traces):
            ticks = lateness(trace)
            self.assertNotEqual(max(late for _, late in ticks), 0, "nothing is ever that punctual")
            self.assertGreater(len(ticks), (CALM + SECONDS) * TICKS_PER_SECOND / 2)
            who = f"peer {i}, flooded" if i == FLOODED else f"peer {i}"
            calm = [late for tick, late in ticks if TICKS_PER_SECOND < tick < self.flood_from]
            wet = [late for tick, late in ticks if self.flood_from <= tick < self.flood_to]
            told = [f"{name} p50 {percentile(v, 50):.2f} p99 {percentile(v, 99):.2f} worst {max(v):.2f} ms"
                    for name, v in (("without", calm), ("with", wet)) if v]  # fmt: skip
            print(f"  {who}: ticks begun late: {'; '.join(told)}", file=sys.stderr)

    def run_one(self, seed, env, more, ids):
        peers, traces = self.play(env, more)
        self.flood_from = self.ticks_of(peers[FLOODED])
        self.flood(peers, seed, ids(peers))
        self.flood_to = self.ticks_of(peers[FLOODED])
        self.check(peers, traces)
        return peers

    def ticks_of(self, peer):
        """The tick it told last in its log; at most a second ago."""
        told = [line.split("status:")[1].split()[0] for line in peer.text().split("\n") if "status:" in line]
        return int(float(told[-1]) * TICKS_PER_SECOND) if told else 0

    def test_without_a_key(self):
        seed = int(os.environ.get("PADR_SEED", "9"))
        print(f"\n  seed {seed}, without a key", file=sys.stderr)
        self.run_one(seed, None, lambda i: [], lambda peers: [])

    def test_with_a_key(self):
        seed = int(os.environ.get("PADR_SEED", "9"))
        print(f"\n  seed {seed}, with a key", file=sys.stderr)
        log = os.path.join(self.folder.name, "keys")

        def known(_):
            with open(log) as lines:
                senders = {line.split()[1] for line in lines}
            return sorted(f"{int.from_bytes(bytes.fromhex(key)[:4], 'little'):x}" for key in senders)

        peers = self.run_one(seed, {**os.environ, "PADR_KEY": KEY},
                             lambda i: ["--keylog", log] if i == FLOODED else [], known)  # fmt: skip
        seal = peers[FLOODED].summary()["seal"]
        print(f"  the flooded one's seals: {seal}", file=sys.stderr)
        self.assertEqual(seal["moves"], 0)
        self.assertGreater(seal["dropped"]["tag"], 0)
        self.assertGreater(seal["dropped"]["form"], 0)


main()
