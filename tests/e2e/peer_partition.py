#!/usr/bin/env python3
"""End to end: the network falls into two halves for ten seconds, and heals.

It needs a network of its own, in which it may cut the loopback interface in two: a namespace for which nobody has to be
root, but which a system may forbid. Where that is so the test is skipped (exit code 77) and says why.

Usage: peer_partition.py PATH_TO_PADR_PEER [unittest arguments]
"""

import os
import shutil
import subprocess
import sys

INSIDE = "PADR_INSIDE_ITS_OWN_NETWORK"
A, B = "127.0.1", "127.0.2"  # where the two halves are


def go_inside():
    """Begins again in a network of its own, or ends with why that cannot be."""
    for program in ("unshare", "ip"):
        if shutil.which(program) is None:
            print(f"skipped: no program '{program}' here")
            sys.exit(77)
    prefix = ["unshare", "--user", "--map-root-user", "--net"]
    trial = subprocess.run([*prefix, "ip", "rule", "add", "pref", "100", "lookup", "local"], capture_output=True, text=True)
    if trial.returncode != 0:
        print(f"skipped: no network of its own here: {trial.stderr.strip()}")
        sys.exit(77)
    os.environ[INSIDE] = "1"
    os.execvp(prefix[0], [*prefix, sys.executable, "-B", *sys.argv])


if INSIDE not in os.environ:
    go_inside()

from peers import PATIENCE, Case, checkpoints, main, signal, time  # noqa: E402


def ip(*words):
    subprocess.run(["ip", *words], check=True)


class Partition(Case):
    CUT = [("10", A, B), ("11", B, A)]

    def setUp(self):
        super().setUp()
        ip("link", "set", "lo", "up")
        # What comes before the table of own addresses may blackhole.
        ip("rule", "add", "pref", "100", "lookup", "local")
        ip("rule", "del", "pref", "0")

    def cut(self):
        for pref, a, b in self.CUT:
            ip("rule", "add", "pref", pref, "from", f"{a}.0/24", "to", f"{b}.0/24", "blackhole")

    def heal(self):
        for pref, _, _ in self.CUT:
            ip("rule", "del", "pref", pref)

    def last(self, peer):
        """Newest life and status: (lives begun, peers present, hash and tick confirmed)."""
        lines = [line for line in list(peer.log) if " status: " in line]
        return lines[-1] if lines else ""

    def test_two_halves_become_one_again(self):
        flags = ["--netem", "delay 30ms 10ms loss 2%", "--status-interval", 0.2]
        founder = self.peer("--listen", f"{A}.1:0", "--wait-peers", 4, *flags)
        port = founder.port()
        peers = [founder]
        for own in (f"{A}.2", f"{B}.1", f"{B}.2"):
            peers.append(self.peer("--listen", f"{own}:0", "--join", f"{A}.1:{port}", *flags))
        for p in peers:
            p.wait_for(r" status: .*peers 4/")
        time.sleep(2)
        self.cut()
        time.sleep(10)
        for p in peers:
            self.assertIn("peers 2/", self.last(p), "each half plays on by itself")
        self.heal()
        healed = time.monotonic()
        for p in peers:
            while "peers 4/" not in self.last(p):
                self.assertLess(time.monotonic(), healed + PATIENCE, p.text())
                time.sleep(0.01)
        print(f"partition of 4 into 2+2 for 10 s: all four there again {time.monotonic() - healed:.2f} s after healing")
        time.sleep(4)
        for p in peers:
            p.process.send_signal(signal.SIGINT)
        self.assertEqual([p.end() for p in peers], [0] * 4)
        self.check_agreement(peers, least_common=2)
        lives = [len(p.summary()["lives"]) for p in peers]
        self.assertEqual(sorted(lives), [1, 1, 2, 2], "one half's world is everybody's now")
        common = set.intersection(*[set(checkpoints(p.summary())) for p in peers])
        print(f"  identical at {len(common)} whole seconds that all four have confirmed since")


if __name__ == "__main__":
    main()
