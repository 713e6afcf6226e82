#!/usr/bin/env python3
"""End to end: peers that come late, are killed, stand still and come back.

Usage: peer_lives.py PATH_TO_PADR_PEER [unittest arguments]
"""

import os

import crowd
from peers import PATIENCE, PLAYING, Case, main, signal, time

LINK = "delay 50ms"


class Lives(Case):
    def running(self, count, *arguments, own=None):
        """A session of so many that has been playing for a second."""
        peers = self.session(count, "--netem", LINK, *arguments, own=own)
        for p in peers:
            p.wait_for(r" status: ")
        return peers

    def newcomer(self, by, *arguments):
        peer = self.peer("--join", f"127.0.0.1:{by.port()}", "--netem", LINK, *arguments)
        peer.wait_for(PLAYING)
        return peer

    def settle(self, peers):
        """Until each has confirmed something of after now."""
        ticks = [int(p.wait_for(r" status: .*@(\d+)")[1]) for p in peers]
        for p in peers:
            newest = max(int(line.split("@")[1].split()[0]) for line in p.log if " status: " in line)
            ticks.append(newest)
        goal = max(ticks) + 240
        deadline = time.monotonic() + PATIENCE
        for p in peers:
            while not any(" status: " in line and int(line.split("@")[1].split()[0]) >= goal for line in list(p.log)):
                self.assertLess(time.monotonic(), deadline, f"confirmed has not got to tick {goal}\n{p.text()}")
                time.sleep(0.05)

    def end_all(self, peers):
        for p in peers:
            p.process.send_signal(signal.SIGINT)
        self.assertEqual([p.end() for p in peers], [0] * len(peers))

    def test_late_joiner_plays(self):
        peers = self.running(2)
        late = self.newcomer(peers[1])  # by any member
        self.settle([*peers, late])
        self.end_all([*peers, late])
        self.check_agreement([*peers, late], least_common=2)
        s = late.summary()
        print(f"late join on a link of 50 ms each way: {s['join_ms']:.0f} ms from the start of the process to its first tick")
        self.assertGreater(s["first_tick"], 30)
        self.assertEqual(s["peer"], 2)
        self.assertGreater(s["incarnation"], 0)
        self.assertEqual(len(s["lives"]), 1)
        for p in peers:
            self.assertEqual(p.summary()["others"]["came"], 1)

    def test_a_spectator_that_is_alone_does_not_stay_for_players(self):
        watches = self.peer("--spectate", "--wait-peers", 1, "--duration", 6, "--linger", 300)
        player = self.newcomer(watches, "--duration", 1)
        self.assertEqual([p.end() for p in (player, watches)], [0, 0])

    def test_killed_peer_and_then_the_founder(self):
        peers = self.running(4)
        victim, founder = peers[2], peers[0]
        number = victim.wait_for(r"this is peer (\d+)")[1]
        victim.process.kill()
        rest = [p for p in peers if p is not victim]
        for p in rest:
            p.wait_for(f"peer {number} is lost: out from tick", 15)
        founder.process.kill()
        rest.remove(founder)
        for p in rest:
            p.wait_for("peer 0 is lost: out from tick", 15)
        late = self.newcomer(rest[-1])
        self.settle([*rest, late])
        self.end_all([*rest, late])
        self.check_agreement([*rest, late], least_common=2)
        for p in rest:
            s = p.summary()
            self.assertEqual(s["others"]["removed"], 2)
            lost = {link["peer"] for link in s["links"] if link["lost"]}
            self.assertLessEqual(lost, {0, int(number)})

    def test_killed_founder_comes_back_to_its_address(self):
        peers = self.running(3)
        founder, others = peers[0], peers[1:]
        port = founder.port()
        founder.process.kill()
        founder.end()
        # Before anybody has missed it, so that it is passed on to where it is itself.
        back = self.peer("--listen", f"127.0.0.1:{port}", "--join", f"127.0.0.1:{others[0].port()}", "--netem", LINK)
        back.wait_for(f"passes us on to 127.0.0.1:{port}")
        back.wait_for(PLAYING)
        self.settle([*others, back])
        self.end_all([*others, back])
        self.check_agreement([*others, back], least_common=2)
        for p in others:
            self.assertEqual(p.summary()["others"]["removed"], 1)

    def test_standing_still_and_coming_back(self):
        os.mkdir(os.path.join(self.folder.name, "one.2.trace"))  # so it cannot be written
        peers = self.running(3, own=[[], ["--trace", os.path.join(self.folder.name, "one.trace")], []])
        frozen = peers[1]
        frozen.process.send_signal(signal.SIGSTOP)
        time.sleep(5)
        frozen.process.send_signal(signal.SIGCONT)
        woken = time.monotonic()
        frozen.wait_for(r"life 2 begins")
        print(f"after SIGSTOP for 5 s: back in {time.monotonic() - woken:.2f} s")
        self.settle(peers)
        self.end_all([p for p in peers if p is not frozen])
        frozen.process.send_signal(signal.SIGINT)
        self.assertEqual(frozen.end(), 1)
        self.check_agreement(peers, least_common=2)
        self.assertEqual(frozen.summary()["exit_code"], 1)
        self.assertIn("joined again, and this is not recorded", frozen.summary()["reason"])
        self.assertEqual(len(frozen.summary()["lives"]), 2)
        others = [p.summary() for p in peers if p is not frozen]
        for s in others:
            self.assertEqual(len(s["lives"]), 1)
            print(f"  another one meanwhile: longest stall {s['longest_stall_ms']:.1f} ms, {s['stalls']} over 2 ticks")

    def test_standing_still_for_a_moment_is_no_end(self):
        peers = self.running(2)
        peers[1].process.send_signal(signal.SIGSTOP)
        time.sleep(1)
        peers[1].process.send_signal(signal.SIGCONT)
        self.settle(peers)
        self.end_all(peers)
        self.check_agreement(peers, least_common=3)
        for p in peers:
            self.assertEqual(len(p.summary()["lives"]), 1)
            self.assertEqual(p.summary()["others"]["removed"], 0)


class Crowd(Case):
    def test_ten_of_whom_one_is_killed_every_five_seconds(self):
        options = crowd.parse([])
        self.assertTrue(crowd.play(options))


if __name__ == "__main__":
    main()
