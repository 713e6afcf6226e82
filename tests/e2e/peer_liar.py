"""A session with a key and a real member that lies: no honest peer is harmed, and a liar that is found out stays out.

Usage: peer_liar.py PADR_PEER PADR_LIAR
"""

import os
import re
import subprocess
import sys

LIAR = sys.argv.pop(2)

from peers import PATIENCE, Case, main  # noqa: E402

KEY = "11" * 32
SECONDS = 24
HONEST = 3
FOUND_OUT = r"peer (\d+) .*(?:cut off|ignored for)"


class Lies(Case):
    def play(self, lie, founder_leaves=SECONDS, differ=False):
        """Honest peers with a liar among them, and the liar's own log. `differ`: it may make confirmed worlds differ."""
        key = self.file("key", KEY)
        os.chmod(key, 0o600)
        common = ("--key-file", key, "--netem", "delay 30ms 5ms loss 1%")
        peers = [self.peer("--wait-peers", HONEST + 1, "--duration", founder_leaves, *common)]
        port = str(peers[0].port())
        peers += [self.peer("--join", f"127.0.0.1:{port}", "--duration", SECONDS, *common) for _ in range(HONEST - 1)]
        liar = subprocess.Popen([LIAR, port, KEY, lie, str(SECONDS)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                text=True)  # fmt: skip
        self.addCleanup(liar.communicate)
        self.addCleanup(liar.kill)
        for peer in peers:
            code = peer.end(SECONDS + PATIENCE)
            self.assertTrue(code == 0 or (differ and code == 1), f"exit {code}\n{peer.text()}")
        said, log = liar.communicate(timeout=SECONDS + PATIENCE)
        self.assertGreater(int(said.split()[0]), 0, f"{lie}: never lied\n{log}")
        return peers, said + log

    def check_honest_stay(self, peers, lie):
        """They began once and confirm the same."""
        for peer in peers:
            self.assertEqual(len(peer.summary()["lives"]), 1, f"{lie}:\n{peer.text()}")
        self.check_agreement(peers, 5)

    def check_only_the_liar_is_cut_off(self, peers, liar):
        (slot,) = re.findall(r"^in the session as peer (\d+)|^admitted at tick \d+ as peer (\d+)", liar, re.M)[:1]
        for peer in peers:
            blamed = set(re.findall(FOUND_OUT, peer.text()))
            self.assertLessEqual(blamed, {slot[0] or slot[1]}, peer.text())

    def test_invented_members_take_nothing_over(self):
        peers, _ = self.play("probes")
        self.check_honest_stay(peers, "probes")
        for peer in peers:
            self.assertNotIn(" on without us", peer.text())

    def test_nobody_honest_is_cut_off_for_what_it_was_told(self):
        peers, log = self.play("epochs", differ=True)  # it tells them to one member only
        self.check_only_the_liar_is_cut_off(peers, log)

    def test_nobody_honest_is_thrown_out_by_polls(self):
        peers, log = self.play("polls")
        self.check_honest_stay(peers, "polls")
        self.check_only_the_liar_is_cut_off(peers, log)

    def test_who_tells_two_stories_stays_out_when_the_coordinator_has_left(self):
        peers, log = self.play("equivocation", founder_leaves=SECONDS * 0.6, differ=True)
        for peer in peers[1:]:
            text = peer.text()
            self.assertIn("has signed two different updates of one number: cut off", text)
            self.assertRegex(text, r"peer \d+ is lost")
        self.assertEqual(log.count("admitted at tick"), 1, log)  # it has asked to come in again
        self.assertIn("joining", log)


if __name__ == "__main__":
    main()
