#!/usr/bin/env python3
"""End to end: peers play over real UDP and believe the same.

Usage: peer_play.py PATH_TO_PADR_PEER [unittest arguments]
"""

import os
import random
import threading

from peers import Case, PATIENCE, main, run, signal, socket, time, unittest, has_ipv6_loopback

BAD = "delay 60ms 30ms loss 10% duplicate 1% reorder 2% corrupt 0.5%"


class Play(Case):
    def test_three_peers_over_a_bad_network_agree(self):
        traces = [os.path.join(self.folder.name, f"{i}.trace") for i in range(3)]
        own = [["--netem-seed", 10 + i, "--input", f"wander:{i}", "--trace", traces[i]] for i in range(3)]
        peers = self.session(3, "--duration", 6, "--linger", 8, "--netem", BAD, own=own)
        self.assertEqual([p.end() for p in peers], [0, 0, 0])
        self.check_agreement(peers, least_common=6)
        for i, p in enumerate(peers):
            s = p.summary()
            self.assertGreaterEqual(s["ticks"], 360)
            self.assertEqual(s["reason"], "played to the end")
            self.assertGreaterEqual(s["confirmed"]["tick"], 360)
            self.assertGreater(s["confirmed"]["checks"], 0)
            self.assertEqual(s["netem_seed"], 10 + i)
            self.assertIn("--netem-seed", s["command"])
            self.assertTrue(s["revision"])
            self.assertEqual(len(s["links"]), 2)
            for link in s["links"]:
                self.assertTrue(link["left"])
                self.assertGreater(link["rtt_ms"], 60)
                shim = link["shim"]
                self.assertGreater(shim["lost"], 0)
                total = shim["released"] + shim["lost"] + shim["overlimit"] + shim["in_flight"]
                self.assertEqual(shim["accepted"] + shim["duplicated"], total)
            self.assertGreater(os.path.getsize(traces[i]), 10_000)
        numbers = {p.summary()["session"]["number"] for p in peers}
        self.assertEqual(len(numbers), 1)
        self.assertEqual(sorted(p.summary()["peer"] for p in peers), [0, 1, 2])

    def test_the_papers_technique_on_a_perfect_network(self):
        path = self.file("line.csv", "t,x,y\n0,2,2\n1,8,6\n2,12,9\n3,4,12\n")
        peers = self.session(2, "--duration", 3, "--technique", "adaptive", "--input", f"path:{path},loop")
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, least_common=3)

    def test_a_round_trip_of_less_than_two_ticks_is_seen(self):
        peers = self.session(2, "--duration", 3, "--netem", "delay 15ms")
        self.assertEqual([p.end() for p in peers], [0, 0])
        for p in peers:
            self.assertGreaterEqual(p.summary()["links"][0]["rtt_ms"], 29.9)

    def test_per_destination_impairment(self):
        founder = self.peer("--wait-peers", 3, "--duration", 2, "--netem", "delay 1ms", "--netem-to", "2=delay 50ms")
        port = founder.port()
        others = [self.peer("--join", f"127.0.0.1:{port}", "--duration", 2)]
        others[0].wait_for("welcomed by")
        others.append(self.peer("--join", f"127.0.0.1:{port}", "--duration", 2,
                                "--netem-to", f"127.0.0.1:{port}=delay 2ms"))  # fmt: skip
        self.assertEqual([p.end() for p in [founder, *others]], [0, 0, 0])
        netem = {link["peer"]: link["shim"]["netem"] for link in founder.summary()["links"]}
        self.assertEqual(netem, {1: "delay 1ms", 2: "delay 50ms"})
        netem = {link["peer"]: link["shim"]["netem"] for link in others[1].summary()["links"]}
        self.assertEqual(netem, {0: "delay 2ms", 1: ""})

    def test_a_narrow_link_is_found(self):
        narrow = ["--technique", "everything", "--netem", "delay 30ms rate 32kbit limit 100"]
        peers = self.session(2, "--duration", 12, own=[narrow, []])
        peers[0].wait_for(r"status: .* narrow: 1 at \d")
        self.assertEqual([p.end() for p in peers], [0, 0])
        (link,) = peers[0].summary()["links"]
        self.assertGreater(link["kbit_s"], 16)
        self.assertLess(link["kbit_s"], 48)
        (link,) = peers[1].summary()["links"]
        self.assertEqual((link["kbit_s"], link["queue_ms"], link["carried_by"]), (None, 0, None))

    def test_alone(self):
        peer = self.peer("--wait-peers", 1, "--duration", 1, "--scenario", "dominoes")
        self.assertEqual(peer.end(), 0)
        self.assertGreaterEqual(peer.summary()["confirmed"]["tick"], 60)

    def test_status_line(self):
        peer = self.peer("--wait-peers", 1, "--duration", 2.5, "--status-interval", 0.5)
        self.assertEqual(peer.end(), 0)
        lines = [line for line in peer.log if " status:" in line]
        self.assertIn(len(lines), range(3, 6))
        for word in ["peers 1/32", "confirmed -", "updates/s", "kbit/s", "own error", "late"]:
            self.assertIn(word, lines[-1])

    def test_json_on_standard_output_is_all_there(self):
        import json

        code, out, _ = run("--wait-peers", 1, "--duration", 0.5, "--json", "-")
        self.assertEqual(code, 0)
        self.assertEqual(json.loads(out)["program"], "padr-peer")


class Leaving(Case):
    def check_goodbye(self, how):
        peers = self.session(3, "--netem", "delay 30ms 10ms loss 10%")
        for p in peers:
            p.wait_for(r"status: ")
        start = time.monotonic()
        peers[1].process.send_signal(how)
        self.assertEqual(peers[1].end(10), 0)
        self.assertLess(time.monotonic() - start, 5)
        self.assertEqual(peers[1].summary()["reason"], "stopped")
        number = peers[1].summary()["peer"]
        for p in (peers[0], peers[2]):
            p.wait_for(f"peer {number} has left", 5)
            p.wait_for(r"peers 2/32", 5)
            p.process.send_signal(how)
        self.assertEqual([p.end(10) for p in peers], [0, 0, 0])
        self.check_agreement(peers, least_common=1)

    def test_sigint_says_goodbye(self):
        self.check_goodbye(signal.SIGINT)

    def test_sigterm_too(self):
        self.check_goodbye(signal.SIGTERM)

    def test_says_goodbye_however_short_it_lingers(self):
        # Of many, who has a high number says it some ticks after the signal.
        peers = self.session(6, "--linger", 0.01)
        for p in peers:
            p.wait_for(r"status: ")
        number = {int(p.wait_for(r"this is peer (\d+)")[1]): p for p in peers}
        number[5].process.send_signal(signal.SIGINT)
        self.assertEqual(number.pop(5).end(10), 0)
        for p in number.values():
            p.wait_for("peer 5 has left", 5)
            p.process.send_signal(signal.SIGINT)
        self.assertEqual([p.end(10) for p in number.values()], [0] * 5)

    def test_second_signal_quits_at_once(self):
        # A link that delivers nothing: the goodbye cannot arrive, so the first signal alone would take all of --linger.
        peers = self.session(2, "--linger", 60)
        for p in peers:
            p.wait_for(r"status: ")
        peers[1].process.kill()
        peers[0].process.send_signal(signal.SIGINT)
        peers[0].wait_for("leaving")
        start = time.monotonic()
        peers[0].process.send_signal(signal.SIGINT)
        self.assertEqual(peers[0].end(5), 1)
        self.assertLess(time.monotonic() - start, 3)
        self.assertIn("second", peers[0].summary()["reason"])

    def test_a_peer_that_crashes_is_lost_once_and_nobody_waits_for_it_forever(self):
        peers = self.session(2, "--duration", 8, "--linger", 2)
        for p in peers:
            p.wait_for(r"status: ")
        peers[1].process.kill()
        self.assertEqual(peers[0].end(), 0)  # ICMP refusals all the while
        lost = [line for line in peers[0].log if "is lost" in line]
        self.assertEqual(len(lost), 1, peers[0].text())
        self.assertTrue(peers[0].summary()["links"][0]["lost"])

    def test_signal_before_the_start(self):
        founder = self.peer("--wait-peers", 3)
        joiner = self.peer("--join", f"127.0.0.1:{founder.port()}")
        joiner.wait_for("waiting as peer")
        joiner.process.send_signal(signal.SIGINT)
        self.assertEqual(joiner.end(5), 1)
        founder.wait_for("peer 1 has left", 5)
        founder.process.send_signal(signal.SIGTERM)
        self.assertEqual(founder.end(5), 1)


class Hostility(Case):
    def test_garbage_thrown_at_a_running_peer(self):
        peers = self.session(2, "--duration", 5)
        ports = [p.port() for p in peers]
        for p in peers:
            p.wait_for("starts in")
        seed = int(os.environ.get("PADR_TEST_SEED", "1"))
        print(f"seed {seed} (PADR_TEST_SEED)")
        rng = random.Random(seed)
        over = time.monotonic() + 4
        thrown = 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            while time.monotonic() < over:
                size = rng.choice([0, 1, 9, 10, 11, 60, 300, 1200, 1201, 5000])
                data = rng.randbytes(size)
                if rng.random() < 0.5:
                    data = b"Pd" + bytes([rng.choice([0x90, 0x91, 0x92, 0x70, 0xF1])]) + data[3:]
                s.sendto(data, ("127.0.0.1", rng.choice(ports)))
                thrown += 1
                if thrown % 50 == 0:
                    time.sleep(0.01)
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, least_common=5)
        self.assertGreater(sum(p.summary()["session"]["datagrams"]["seal"] for p in peers), thrown // 10)
        self.assertLess(len(peers[0].log), 100, "garbage must not flood the log")

    def test_a_replayed_conversation_changes_nothing(self):
        """What two peers say to each other, said again by a stranger, many times."""
        heard = []
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as tap:
            tap.bind(("127.0.0.1", 0))
            tap.settimeout(0.2)
            founder = self.peer("--wait-peers", 2, "--duration", 4)
            port = founder.port()
            joiner = self.peer("--join", f"127.0.0.1:{tap.getsockname()[1]}", "--join-timeout", 3)
            real = self.peer("--join", f"127.0.0.1:{port}", "--duration", 4)
            over = time.monotonic() + 2
            while time.monotonic() < over:
                try:
                    heard.append(tap.recvfrom(65536)[0])
                except socket.timeout:
                    pass
            self.assertGreater(len(heard), 3)
            for data in heard * 20:
                tap.sendto(data, ("127.0.0.1", port))
            self.assertEqual(joiner.end(), 1)
            self.assertIn("no answer", joiner.text())
            self.assertEqual([founder.end(), real.end()], [0, 0])
            self.check_agreement([founder, real], least_common=4)


@unittest.skipUnless(has_ipv6_loopback(), "no IPv6 on the loopback interface")
class Ipv6(Case):
    def test_play_over_ipv6(self):
        founder = self.peer("--listen", "[::1]:0", "--wait-peers", 2, "--duration", 2)
        joiner = self.peer("--join", f"[::1]:{founder.port()}", "--duration", 2)
        self.assertEqual([founder.end(), joiner.end()], [0, 0])
        self.check_agreement([founder, joiner], least_common=2)
        self.assertTrue(joiner.summary()["links"][0]["endpoint"].startswith("[::1]:"))

    def test_a_peer_of_both_families_joins_by_ipv4(self):
        founder = self.peer("--wait-peers", 2, "--duration", 2)
        at = f"127.0.0.1:{founder.port()}"
        joiner = self.peer("--listen", "[::]:0", "--insecure", "--join", at, "--netem-to", f"{at}=delay 5ms", "--duration", 2)
        self.assertEqual([founder.end(), joiner.end()], [0, 0])
        self.check_agreement([founder, joiner], least_common=2)
        link = joiner.summary()["links"][0]
        self.assertEqual((link["endpoint"], link["shim"]["netem"]), (at, "delay 5ms"))


if __name__ == "__main__":
    main()
