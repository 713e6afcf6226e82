#!/usr/bin/env python3
"""One world on two processors: lab runs, traces, captures and sessions of real processes, identical to the bit.

Usage: processors.py OURS OTHERS [--all] [unittest arguments]

  OURS     folder with this machine's padr-lab, padr-peer, padr-capture and padr-report
  OTHERS   folder with programs of the same names that compute on another processor, as .ci/aarch64.sh makes it
  --all    40 lab runs of 20 s instead of a few short ones: some minutes
"""

import filecmp
import glob
import json
import os
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "e2e"))
ALL = "--all" in sys.argv
if ALL:
    sys.argv.remove("--all")
OTHERS = os.path.abspath(sys.argv.pop(2))
OURS = os.path.abspath(sys.argv[1])
sys.argv[1] = os.path.join(OURS, "padr-peer")

from peers import PLAYING, Case, main, signal  # noqa: E402

LINK = "delay 100ms 50ms loss 10% duplicate 2%"
TECHNIQUES = ("full", "adaptive", "everything", "fixed", "avatar-only")
ROOM = {"arena": 8, "ball": 4, "clutter": 8, "dominoes": 4, "pitch": 8, "proxy": 4, "van": 4}  # for so many peers, at most 8
SHORT = [
    ("arena", 4, "full", []),
    ("clutter", 3, "adaptive", ["--convergence", "blend"]),
    ("pitch", 6, "full", ["--predictor", "pcc"]),
    ("dominoes", 2, "everything", []),
    ("van", 4, "fixed", ["--convergence", "pvb"]),
]
MORE = [
    ("arena", 8, "full", ["--precision", "exact"]),
    ("arena", 5, "full", ["--replay", "off", "--convergence", "blend"]),
    ("clutter", 7, "full", ["--predictor", "density", "--threshold-law", "continuous"]),
    ("pitch", 4, "adaptive", ["--predictor", "path-density", "--model", "second"]),
    ("arena", 6, "full", ["--budget", "12", "--convergence", "snap"]),
]


def all_runs():
    """Every scenario with every technique, by 2 to 8 peers, and a few more knobs."""
    pairs = [(s, t) for s in ROOM for t in TECHNIQUES]
    return [(s, 2 + i % (ROOM[s] - 1), t, []) for i, (s, t) in enumerate(pairs)] + MORE


def header_end(data):
    """Where a trace's first record ends: it holds the command and the revision, which may differ."""
    at, length, shift = 8, 0, 0
    while True:
        byte = data[at]
        at, length, shift = at + 1, length | (byte & 127) << shift, shift + 7
        if byte < 128:
            return at + length


def events(path):
    with open(path, "rb") as file:
        data = file.read()
    return data[header_end(data):]


class Processors(Case):
    def run_program(self, folder, program, *arguments, code=0, cwd=None):
        done = subprocess.run([os.path.join(folder, program), *map(str, arguments)], cwd=cwd, capture_output=True, text=True,
                              errors="replace", timeout=3600 if ALL else 600)  # fmt: skip
        allowed = [code] if isinstance(code, int) else code
        self.assertIn(done.returncode, allowed, f"{program} {arguments}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def place(self, *names):
        path = os.path.join(self.folder.name, *names)
        os.makedirs(path, exist_ok=True)
        return path


class Fingerprint(Processors):
    def need_mistakes(self):
        if not os.path.exists(os.path.join(OTHERS, "seeded_right")):
            self.skipTest(f"no programs with mistakes in {OTHERS}: .ci/aarch64.sh --mistakes makes them")

    def test_is_the_same(self):
        ours, theirs = (self.run_program(f, "padr-peer", "fingerprint") for f in (OURS, OTHERS))
        print(ours + theirs, end="")
        self.assertEqual(ours.splitlines()[0], theirs.splitlines()[0])
        self.assertNotEqual(ours.splitlines()[1], theirs.splitlines()[1], "these are not two builds")
        value = ours.split()[1]
        self.assertRegex(value, "^00[0-9a-f]{14}$")
        for folder in (OURS, OTHERS):
            self.assertIn("the same", self.run_program(folder, "padr-peer", "fingerprint", value))

    def test_mistakes_are_caught_by_name(self):
        self.need_mistakes()
        right = self.run_program(OTHERS, "padr-peer", "fingerprint").split()[1]
        table = {
            "right": "the other one's physics is the same",
            "fused": "the other one fuses multiplications and additions: compile it with -ffp-contract=off",
            "package": "the other one has a Box2D that fuses multiplications and additions: compile Box2D with -ffp-contract=off",
            "fast": "the other one adds in another order than written: compile it without -ffast-math",
            "sine": "sines, cosines, arc tangents or roots differ",
            "order": "contacts are solved in another order",
        }
        for name, words in table.items():
            with self.subTest(name):
                theirs = self.run_program(OTHERS, f"seeded_{name}").strip()
                self.assertEqual(theirs == right, name == "right")
                said = self.run_program(OURS, "padr-peer", "fingerprint", theirs, code=int(theirs != right))
                print(f"{name}: {theirs} {said.splitlines()[-1]}")
                self.assertIn(words, said)

    def test_what_goes_unseen_on_most_machines_shows(self):
        """What nobody has set holds patterns there, and no char is negative; elsewhere these mistakes may change nothing."""
        self.need_mistakes()
        right = self.run_program(OTHERS, "seeded_right")
        for mistake in ("variable", "memory", "char"):
            with self.subTest(mistake):
                theirs = self.run_program(OTHERS, f"seeded_{mistake}")
                print(f"{mistake}: {theirs.strip()}")
                self.assertNotEqual(theirs, right)


class UnitTests(Processors):
    def test_of_the_world_pass_there(self):
        # Not those that start processes of their own, nor those that take a minute there.
        said = self.run_program(OTHERS, "world_test", "--gtest_filter=PortableMath.*:Fingerprint.*:World.*-*Variants")
        self.assertIn("EveryBitIsTheSameEverywhere", said)
        print(said.strip().splitlines()[-1])


class Lab(Processors):
    def play(self, folder, where, scenario, peers, technique, more, seconds=5, seed=7):
        arguments = ["run", "--scenario", scenario, "--peers", peers, "--technique", technique, *more, "--netem", LINK]
        arguments += ["--seed", seed, "--seconds", seconds, "--trace", "traces", "--json", "run.json", "--csv", "run.csv"]
        self.run_program(folder, "padr-lab", *arguments, cwd=where)

    def difference(self, ours, theirs):
        """Of two folders of traces: what differs first, in words; empty if nothing does."""
        names = sorted(os.listdir(ours))
        self.assertEqual(names, sorted(os.listdir(theirs)))
        for name in names:
            mine, other = os.path.join(ours, name), os.path.join(theirs, name)
            if events(mine) != events(other):
                return f"{name}: " + self.run_program(OURS, "padr-lab", "replay", other, code=[0, 1, 2])
        return ""

    def test_runs_are_the_same(self):
        """Every event of every peer: confirmed hashes, live hashes and shown positions of all ticks, all datagrams."""
        for i, run in enumerate(all_runs() if ALL else SHORT):
            with self.subTest(run=run):
                began = time.monotonic()
                ours, theirs = self.place(f"ours{i}"), self.place(f"theirs{i}")
                for folder, where in ((OURS, ours), (OTHERS, theirs)):
                    self.play(folder, where, *run, seconds=20 if ALL else 5)
                self.assertEqual(self.difference(os.path.join(ours, "traces"), os.path.join(theirs, "traces")), "")
                self.assertTrue(filecmp.cmp(os.path.join(ours, "run.csv"), os.path.join(theirs, "run.csv"), shallow=False))
                with open(os.path.join(theirs, "run.json"), encoding="utf-8") as file:
                    said = json.load(file)
                self.assertGreater(said["confirmed_ticks"], 60)
                size = sum(os.path.getsize(os.path.join(theirs, "traces", n)) for n in os.listdir(os.path.join(theirs, "traces")))
                print(f"{run}: {said['confirmed_ticks']} confirmed ticks, hash {said['confirmed_hash']}, {size} bytes of events "
                      f"identical, {time.monotonic() - began:.0f} s")  # fmt: skip

    def test_traces_replay_there_and_back(self):
        for maker, reader in ((OURS, OTHERS), (OTHERS, OURS)):
            where = self.place(os.path.basename(os.path.dirname(maker)) or "x")
            self.play(maker, where, "arena", 3, "full", [], seconds=3)
            for name in sorted(os.listdir(os.path.join(where, "traces"))):
                said = self.run_program(reader, "padr-lab", "replay", os.path.join(where, "traces", name))
                self.assertIn(": identical: peer", said)

    def test_a_difference_is_found_and_named(self):
        where = [self.place("a"), self.place("b")]
        for seed, folder in enumerate(where):
            self.play(OURS, folder, "arena", 2, "full", [], seconds=1, seed=seed)
        self.assertIn("peer0.trace: ", self.difference(*(os.path.join(w, "traces") for w in where)))


class Session(Processors):
    """Two peers of each processor, with a key, on bad links; one of each is killed, and comes back."""

    def test_mixed(self):
        key = self.file("key", "5a" * 32)
        traces, captures = [], []

        def start(folder, *arguments):
            i = len(traces)
            files = [os.path.join(self.folder.name, f"{i}.{ending}") for ending in ("trace", "pcapng", "keys")]
            traces.append((folder, files[0]))
            captures.append((folder, files[1], files[2]))
            return self.peer(*arguments, "--key-file", key, "--netem", LINK, "--netem-seed", i + 1, "--input", f"wander:{i}",
                             "--trace", files[0], "--pcap", files[1], "--keylog", files[2],
                             program=os.path.join(folder, "padr-peer"))  # fmt: skip

        founder = start(OURS, "--wait-peers", 4)
        join = ["--join", f"127.0.0.1:{founder.port()}"]
        peers = [founder] + [start(folder, *join) for folder in (OTHERS, OURS, OTHERS)]
        for p in peers:
            p.wait_for(PLAYING, 60)
            p.wait_for(" status: ", 60)
        for victim, folder in ((2, OURS), (3, OTHERS)):
            time.sleep(2)
            peers[victim].process.kill()
            peers[victim].end()
            again = start(folder, *join)
            again.wait_for(PLAYING, 60)
            peers[victim] = again
        time.sleep(6)
        for p in peers:
            p.process.send_signal(signal.SIGINT)
        self.assertEqual([p.end(60) for p in peers], [0] * 4)
        self.check_agreement(peers, least_common=2)
        self.check_traces(traces)
        self.check_captures(captures, [t for _, t in traces])

    def check_traces(self, traces):
        # A peer that a busy machine holds up for long comes in anew, and has another trace.
        lives = [(f, t) for f, first in traces for t in sorted(glob.glob(first[: -len("trace")] + "*trace"))]
        report = json.loads(self.run_program(OURS, "padr-report", *[t for _, t in lives], "--json", "-"))
        said = {name: report[name] for name in ("lives", "confirmed_ticks", "confirmed_mismatches", "given_up_unlike")}
        print("mixed session:", said)
        self.assertGreaterEqual(report["lives"], 6)
        self.assertGreater(report["confirmed_ticks"], 300)
        self.assertEqual((report["confirmed_mismatches"], report["given_up_unlike"]), (0, 0))
        for maker, trace in lives:
            said = self.run_program(OTHERS if maker == OURS else OURS, "padr-lab", "replay", trace)
            self.assertIn(": identical: peer", said)

    def check_captures(self, captures, traces):
        """Of the two founding members of each processor that were not killed: rebuilt on the other one."""
        for maker, capture, keys in captures[:2]:
            other = OTHERS if maker == OURS else OURS
            rebuilt = json.loads(self.run_program(other, "padr-capture", "rebuild", capture, "--keylog", keys, "--json", "-"))
            self.assertEqual(rebuilt["agreeing"], rebuilt["hashes"])
            self.assertGreater(rebuilt["hashes"], 10)
            compared = json.loads(self.run_program(other, "padr-capture", "compare", capture, *traces, "--keylog", keys, "--json", "-"))
            self.assertTrue(compared["agree"], compared)


if __name__ == "__main__":
    main()
