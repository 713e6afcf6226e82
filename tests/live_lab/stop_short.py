#!/usr/bin/env python3
"""The paper's Figures 2 and 3 with real peers over real UDP: one avatar stops just short of the ball, of the first domino,
and its model at the other peer runs on. Without authority that costs metres; with it, in the paper's techniques and in
full, nothing.

Usage: stop_short.py PADR_PEER PADR_REPORT FOLDER_OF_PATHS
"""

import csv
import os
import re
import subprocess
import sys
import tempfile
import time

PEER, REPORT, PATHS = sys.argv[1:4]
SECONDS = 10
STORIES = ["ball", "dominoes"]
TECHNIQUES = {"avatar-only": ["--threshold", "0.8"], "fixed": ["--threshold", "0.8"], "adaptive": [], "full": []}
LEAST_WITHOUT = 15.0  # m
MOST_WITH = 0.005  # m; below it everything is noise


class Play:
    """A session of two, under way: the avatar of the first one takes the path, the other stays and watches."""

    def __init__(self, folder, story, technique):
        self.story, self.technique = story, technique
        self.name = os.path.join(folder, f"{story}-{technique}")
        self.common = ["--scenario", story, "--technique", technique, *TECHNIQUES[technique], "--duration", str(SECONDS), "--linger", "5"]
        path = os.path.join(PATHS, f"{story}.csv")
        self.peers = [self.start(0, "--listen", "127.0.0.1:0", "--wait-peers", "2", "--input", f"path:{path}")]

    def start(self, index, *flags):
        log = open(f"{self.name}-{index}.log", "w")
        return subprocess.Popen([PEER, *flags, *self.common, "--trace", f"{self.name}-{index}.trace"], stderr=log)

    def log(self, index):
        return open(f"{self.name}-{index}.log").read()

    def join(self):
        port = None
        while port is None:
            assert self.peers[0].poll() is None, self.log(0)
            found = re.search(r"listening on 127\.0\.0\.1:(\d+)", self.log(0))
            port = found and found.group(1)
            time.sleep(0.02)
        self.peers.append(self.start(1, "--join", f"127.0.0.1:{port}", "--input", "rest"))

    def end(self):
        """How far bodies are off in the watcher's view, summed, m: (at the worst, in the end)."""
        for i, p in enumerate(self.peers):
            code = p.wait(timeout=SECONDS + 60)
            assert code == 0, f"{self.name}: peer {i} ended with {code}:\n{self.log(i)}"
        report = subprocess.run([REPORT, *(f"{self.name}-{i}.trace" for i in range(2)), "--csv", self.name], capture_output=True, text=True)
        assert report.returncode == 0, report.stdout + report.stderr
        with open(os.path.join(self.name, "inconsistency.csv"), encoding="utf-8") as rows:
            off = [float(r["body_m"]) for r in csv.DictReader(rows) if r["peer"] == "1"]
        assert len(off) >= (SECONDS - 1) * 60, f"{self.name}: only {len(off)} ticks measured"
        return max(off), off[-1]


def main():
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        plays = [Play(folder, story, technique) for story in STORIES for technique in TECHNIQUES]
        for p in plays:
            p.join()
        for p in plays:
            peak, final = p.end()
            good = final > LEAST_WITHOUT if p.technique == "avatar-only" else peak < MOST_WITH
            print(f"{p.story:9} {p.technique:12} bodies off: {peak:7.3f} m at the worst, {final:7.3f} m in the end{'' if good else '  WRONG'}")
            if not good:
                wrong.append(p.name)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
