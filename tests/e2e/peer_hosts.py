#!/usr/bin/env python3
"""End to end on three machines, as network namespaces behind a switch of their own.

Skipped where namespaces are not permitted.

Usage: peer_hosts.py PATH_TO_PADR_PEER [unittest arguments]
"""

import os
import re
import socket
import subprocess
import threading
import time

from hosts import Machines, main_unless, why_no_namespaces
from peers import PROGRAM, Case

CAPTURE = os.path.join(os.path.dirname(PROGRAM), "padr-capture")


class OnThreeMachines(Case):
    def setUp(self):
        super().setUp()
        self.machines = Machines(3)

    def tearDown(self):
        super().tearDown()
        self.machines.remove()


class ThreeMachines(OnThreeMachines):
    def on(self, machine, *arguments):
        return self.peer("--listen", "0.0.0.0:0", "--insecure", *arguments, preexec_fn=self.machines.enter(machine))

    def test_two_peers_of_one_machine_that_met_on_its_loopback_address(self):
        founder = self.on(1, "--wait-peers", 2, "--duration", 3, "--linger", 0.5)
        elsewhere = self.on(2, "--join", f"10.99.0.1:{founder.port()}", "--duration", 9)
        elsewhere.wait_for("peers? starts in")
        beside = self.on(1, "--join", f"127.0.0.1:{founder.port()}", "--duration", 9)
        beside.wait_for("this is peer 2|in as peer 2")
        self.assertEqual(founder.end(), 0)
        # Whom it looks for at a wrong address it never hears, and takes for lost.
        newcomer = self.on(3, "--join", f"10.99.0.2:{elsewhere.port()}", "--duration", 4)
        newcomer.wait_for(f"peer 2 is at 10.99.0.1:{beside.port()}$")
        self.assertEqual([p.end() for p in (newcomer, elsewhere, beside)], [0, 0, 0])
        for p in self.peers:
            self.assertNotRegex(p.text(), "silent for|is lost|joining anew")
        self.check_agreement([newcomer, elsewhere, beside], least_common=2)


class Apart(OnThreeMachines):
    """Two of the machines do not reach each other."""

    def on(self, machine, *arguments):
        env = {**os.environ, "PADR_KEY": "11" * 32}
        return self.peer("--listen", "0.0.0.0:0", *arguments, env=env, preexec_fn=self.machines.enter(machine))

    def play_three(self, seal):
        self.machines.keep_apart(2, 3)
        founder = self.on(1, "--wait-peers", 3, "--duration", 12, "--seal", seal)
        at = f"10.99.0.1:{founder.port()}"
        packets, keys = (os.path.join(self.folder.name, name) for name in ("2.pcapng", "2.keys"))
        second = self.on(2, "--join", at, "--duration", 12, "--seal", seal, "--pcap", packets, "--keylog", keys)
        second.wait_for("admitted")
        third = self.on(3, "--join", at, "--duration", 12, "--seal", seal)
        for peer, other in ((second, 2), (third, 1)):
            peer.wait_for(f"peer {other} is reached through peer 0")
            peer.wait_for(f"status: .* carried: {other} by 0")
        self.assertEqual([p.end() for p in (founder, second, third)], [0, 0, 0])
        for p in self.peers:
            self.assertNotRegex(p.text(), "silent for|is lost|joining anew")
        self.check_agreement(self.peers, least_common=5)
        carried = founder.summary()["seal"]
        self.assertGreater(carried["carried"], 100)
        self.assertEqual((carried["declined"], carried["dropped"]["tag"]), (0, 0))
        for peer in (second, third):
            self.assertEqual(peer.summary()["seal"]["carried"], 0)
        # What it has got by another one is in its capture as if it had come directly.
        rebuilt = subprocess.run([CAPTURE, "rebuild", packets, "--keylog", keys], check=False, capture_output=True, text=True)
        self.assertEqual(rebuilt.returncode, 0, rebuilt.stderr)
        agreeing, of = map(int, re.search(r"(\d+) of (\d+) hashes agree", rebuilt.stdout).groups())
        self.assertEqual(agreeing, of, rebuilt.stdout)
        self.assertGreater(of, 20)

    def test_readable(self):
        self.play_three("auth")

    def test_encrypted(self):
        self.play_three("encrypt")

    def test_the_link_is_taken_when_it_works(self):
        founder = self.on(1, "--wait-peers", 3, "--duration", 16)
        at = f"10.99.0.1:{founder.port()}"
        second = self.on(2, "--join", at, "--duration", 16)
        second.wait_for("admitted")
        third = self.on(3, "--join", at, "--duration", 16)
        second.wait_for("this is peer")
        self.machines.keep_apart(2, 3)
        for peer, other in ((second, 2), (third, 1)):
            peer.wait_for(f"peer {other} is reached through peer 0")
        self.machines.together(2, 3)
        for peer, other in ((second, 2), (third, 1)):
            peer.wait_for(f"peer {other} is reached directly again")
        self.assertEqual([p.end() for p in (founder, second, third)], [0, 0, 0])
        for p in self.peers:
            self.assertNotRegex(p.text(), "silent for|is lost|joining anew")
        self.check_agreement(self.peers, least_common=5)


class BesideADownload(OnThreeMachines):
    """Two peers and a bulk flow of TCP share what leads to one of them: RFC 8085."""

    RATE = 256  # kbit/s
    SECONDS = 12

    def narrow(self):
        limit = ("rate", f"{self.RATE}kbit", "burst", "2000", "limit", "16000")  # half a second of queue
        try:
            self.machines.run("0", "tc", "qdisc", "replace", "dev", "port2", "root", "tbf", *limit)
        except subprocess.CalledProcessError as error:
            self.skipTest(f"no tbf here: {error.stderr.strip()}")

    def download(self, until):
        """From machine 1 to 2 and as fast as it goes; bytes that came."""
        with self.machines.inside("2"):
            door = socket.create_server(("10.99.0.2", 0))
        with self.machines.inside("1"):
            source = socket.create_connection(door.getsockname())
        sink, _ = door.accept()
        for s in (source, sink):
            s.settimeout(0.2)

        def pour():
            while time.monotonic() < until:
                try:
                    source.send(bytes(4096))
                except TimeoutError:
                    pass

        writer = threading.Thread(target=pour)
        writer.start()
        came = 0
        while time.monotonic() < until:
            try:
                came += len(sink.recv(65536))
            except TimeoutError:
                pass
        writer.join()
        for s in (source, sink, door):
            s.close()
        return came

    def test_both_live(self):
        self.narrow()
        common = ("--listen", "0.0.0.0:0", "--insecure", "--duration", self.SECONDS)
        founder = self.peer(*common, "--wait-peers", 2, preexec_fn=self.machines.enter(1))
        joiner = self.peer(*common, "--join", f"10.99.0.1:{founder.port()}", preexec_fn=self.machines.enter(2))
        joiner.wait_for("play begins|peers? starts in")
        began = time.monotonic()
        came = self.download(began + self.SECONDS - 2)
        share = came * 8 / 1000 / (time.monotonic() - began) / self.RATE
        self.assertEqual([p.end() for p in (founder, joiner)], [0, 0])
        self.check_agreement([founder, joiner], least_common=self.SECONDS - 4)
        for p in self.peers:
            self.assertNotRegex(p.text(), "silent for|is lost|joining anew")
        kbit = founder.summary()["sent"]["wire_bytes"] * 8 / 1000 / self.SECONDS
        print(f"of {self.RATE} kbit/s TCP had {share:.0%}, the peer {kbit / self.RATE:.1%}")
        self.assertGreater(share, 0.5)
        self.assertGreater(kbit, 1)


if __name__ == "__main__":
    main_unless(why_no_namespaces())
