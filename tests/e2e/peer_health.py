#!/usr/bin/env python3
"""End to end: the health file, by which others watch a peer from outside.

Usage: peer_health.py PATH_TO_PADR_PEER [unittest arguments]
"""

import json
import os

from peers import PATIENCE, Case, main, run, signal, time


class Health(Case):
    def path(self, name="peer.health"):
        return os.path.join(self.folder.name, name)

    def wait_for(self, holds, path=None):
        """What the file says once `holds` is true of it; it may not be there yet, but is never half written."""
        deadline = time.monotonic() + PATIENCE
        said = None
        while time.monotonic() < deadline:
            if os.path.exists(path or self.path()):
                with open(path or self.path(), encoding="utf-8") as f:
                    said = json.load(f)
                if holds(said):
                    return said
            time.sleep(0.02)
        self.fail(f"still {said} after {PATIENCE} s")

    def test_unhealthy_until_it_plays_healthy_while_confirmed_advances_gone_at_the_end(self):
        founder = self.peer("--wait-peers", 2, "--health", self.path())
        self.assertEqual(self.wait_for(lambda s: True)["playing"], False)
        waiting = self.wait_for(lambda s: "present" in s)
        self.assertEqual((waiting["healthy"], waiting["playing"], waiting["present"]), (False, False, 1))
        other = self.peer("--join", f"127.0.0.1:{founder.port()}")
        first = self.wait_for(lambda s: s["healthy"])
        self.assertTrue(first["playing"])
        self.assertEqual((first["peer"], first["present"]), (0, 2))
        later = self.wait_for(lambda s: s["confirmed_tick"] >= first["confirmed_tick"] + 60)
        self.assertNotEqual(later["confirmed_hash"], first["confirmed_hash"])
        for p in (other, founder):
            p.process.send_signal(signal.SIGINT)
        self.assertEqual([p.end() for p in (other, founder)], [0, 0])
        self.assertEqual(os.listdir(self.folder.name), [], "neither the file nor a draft of it is left")

    # Once, such a file was replaced and then removed, as root a device, too.
    def test_what_is_no_file_is_refused_and_a_link_stays(self):
        os.mkfifo(self.path("pipe"))
        for path in (self.path("pipe"), self.folder.name, "-"):
            code, _, said = run("--wait-peers", 1, "--duration", 1, "--health", path)
            self.assertEqual(code, 2, said)
            self.assertIn("--health: ", said)
        os.symlink("target", self.path("link"))
        peer = self.peer("--wait-peers", 1, "--health", self.path("link"))
        self.wait_for(lambda s: s["playing"], self.path("target"))
        self.assertTrue(os.path.islink(self.path("link")))
        peer.process.send_signal(signal.SIGINT)
        self.assertEqual(peer.end(), 0)

    def test_confirmed_that_stands_still_shows(self):
        flags = ["--health", self.path()]
        founder = self.peer("--wait-peers", 2, *flags)
        other = self.peer("--join", f"127.0.0.1:{founder.port()}")
        self.wait_for(lambda s: s["healthy"])
        other.process.send_signal(signal.SIGSTOP)  # until it is declared gone, confirmed waits for it
        still = self.wait_for(lambda s: s["confirmed_still_ms"] > 1500)
        self.assertTrue(still["healthy"], "for it may take so long")
        on = self.wait_for(lambda s: s["confirmed_tick"] > still["confirmed_tick"])
        self.assertLess(on["confirmed_still_ms"], 1500)
        founder.process.send_signal(signal.SIGINT)
        self.assertEqual(founder.end(), 0)

    def test_a_file_that_cannot_be_written_is_a_wrong_argument(self):
        bad = self.path("nowhere/peer.health")
        code, _, said = run("--wait-peers", "1", "--duration", "1", "--health", bad)
        self.assertEqual(code, 2)
        self.assertIn(f"--health: cannot write '{bad}", said)
        self.assertEqual(said.count("\n"), 1)


if __name__ == "__main__":
    main()
