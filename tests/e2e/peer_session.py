#!/usr/bin/env python3
"""End to end: coming together, and being told why not.

Usage: peer_session.py PATH_TO_PADR_PEER [unittest arguments]
"""

import ctypes
import os
import shutil
import struct
import subprocess
import time
import zlib

from peers import PROGRAM, Case, main, run, socket, time


class Joining(Case):
    def test_through_a_member_by_name(self):
        founder = self.peer("--wait-peers", 3, "--duration", 2)
        second = self.peer("--join", f"localhost:{founder.port()}", "--duration", 2)
        second.wait_for("welcomed by")
        third = self.peer("--join", f"localhost:{second.port()}", "--duration", 2)
        third.wait_for("passes us on to")
        self.assertEqual([p.end() for p in (founder, second, third)], [0, 0, 0])
        self.check_agreement([founder, second, third], least_common=2)

    def test_where_nobody_answers_the_next_member_is_asked(self):
        founder, second = self.session(2, "--duration", 4)
        second.wait_for("status:")
        late = self.peer("--join", "127.0.0.1:1", "--join", f"127.0.0.1:{second.port()}", "--duration", 1)
        late.wait_for(f"or 127.0.0.1:{second.port()}")
        late.wait_for("welcomed by")
        self.assertEqual([p.end() for p in (founder, second, late)], [0, 0, 0])
        self.check_agreement([founder, second, late], least_common=1)

    def test_joiners_may_come_first(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            s.bind(("127.0.0.1", 0))
            port = s.getsockname()[1]
        joiner = self.peer("--join", f"127.0.0.1:{port}", "--duration", 1)
        joiner.wait_for("joining")
        time.sleep(0.7)  # ICMP refusals in between
        founder = self.peer("--listen", f"127.0.0.1:{port}", "--duration", 1)
        self.assertEqual([founder.end(), joiner.end()], [0, 0])

    def test_handshake_through_heavy_loss(self):
        peers = self.session(2, "--duration", 1, "--netem", "delay 50ms 40ms loss 30% duplicate 5%", "--linger", 5)
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, least_common=1)

    def test_link_trace_of_a_file_holds_datagrams_back(self):
        spec = "trace " + self.file("my.link", "400\n" * 40)  # 40 packets at once, every 400 ms
        peers = self.session(2, "--duration", 3, "--netem", spec, "--linger", 5)
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, least_common=1)
        round_trips = 0
        for p in peers:
            summary = p.summary()
            self.assertEqual(summary["netem"], spec)
            (link,) = summary["links"]
            self.assertEqual(link["shim"]["netem"], spec)
            self.assertEqual((link["shim"]["lost"], link["shim"]["overlimit"]), (0, 0))
            self.assertGreater(link["shim"]["released"], 5)
            round_trips += link["rtt_ms"]
        # Each of the two waits 200 ms on average for its own link, and together 400 ms for the other's.
        self.assertGreater(round_trips, 250)

    def test_nobody_comes(self):
        founder = self.peer("--wait-peers", 2, "--join-timeout", 1)
        self.assertEqual(founder.end(), 1)
        self.assertIn("only 1 of 2 players came within 1 s", founder.text())
        self.assertFalse(founder.summary()["session"]["started"])

    def test_nobody_answers(self):
        joiner = self.peer("--join", "127.0.0.1:1", "--join-timeout", 1)
        self.assertEqual(joiner.end(), 1)
        self.assertIn("no answer from 127.0.0.1:1 within 1 s: nobody listens there", joiner.text())

    def test_no_name_server_answers_yet(self):
        alone = shutil.which("unshare") and subprocess.run(["unshare", "-rn", "true"], capture_output=True).returncode == 0
        if not alone:
            self.skipTest("no network namespaces here")
        begin = time.monotonic()
        result = subprocess.run(["unshare", "-rn", PROGRAM, "--listen", "0.0.0.0:0", "--insecure", "--join", "host.invalid:7001",
                                 "--join-timeout", "2"], capture_output=True, text=True, timeout=60)  # fmt: skip
        self.assertEqual(result.returncode, 2)
        self.assertGreater(time.monotonic() - begin, 2)
        self.assertEqual(result.stderr.count("cannot resolve 'host.invalid'"), 2, result.stderr)
        self.assertIn("; trying on", result.stderr)


class Refusal(Case):
    def check_refused(self, founder_flags, joiner_flags, *words):
        founder = self.peer("--wait-peers", 2, "--duration", 1, *founder_flags)
        port = founder.port()
        odd = self.peer("--join", f"127.0.0.1:{port}", *joiner_flags)
        self.assertEqual(odd.end(), 1)
        founder.wait_for("refused")
        for word in words:
            self.assertIn(word, odd.text())
            self.assertIn(word, founder.text())
        self.assertIn("refused", odd.summary()["reason"])
        # The session is none the worse for it.
        fitting = self.peer("--join", f"127.0.0.1:{port}", "--duration", 1, *founder_flags)
        self.assertEqual([founder.end(), fitting.end()], [0, 0])

    def test_another_scenario(self):
        self.check_refused([], ["--scenario", "ball"], "scenario differs", "arena seed 1", "ball seed 1")

    def test_another_seed(self):
        self.check_refused(["--seed", 4], ["--seed", 5], "scenario differs", "arena seed 4", "arena seed 5")

    def test_another_authority_rule(self):
        self.check_refused([], ["--technique", "avatar-only"], "authority rule differs", "dynamic", "avatar-only")

    def test_full_session_that_runs(self):
        peers = self.session(2, "--duration", 8, own=[["--slots", 2], []])
        for p in peers:
            p.wait_for("status:")
        late = self.peer("--join", f"127.0.0.1:{peers[1].port()}")
        self.assertEqual(late.end(), 1)
        self.assertIn("refused", late.text())
        self.assertIn("full", late.text())
        self.assertEqual([p.end() for p in peers], [0, 0])

    def test_another_scenario_while_the_session_runs(self):
        peers = self.session(2, "--duration", 4)
        for p in peers:
            p.wait_for("status:")
        late = self.peer("--join", f"127.0.0.1:{peers[1].port()}", "--scenario", "clutter")
        self.assertEqual(late.end(), 1)
        self.assertIn("scenario differs", late.text())
        self.assertEqual([p.end() for p in peers], [0, 0])

    def test_another_protocol_version(self):
        """A newcomer from the future, as far as the rules that all versions keep go: see proto/WIRE.md."""

        def future(body):
            data = b"Pd" + bytes([0xA1, 0xFF, 0, 0]) + body
            return data + struct.pack("<I", zlib.crc32(data))

        founder = self.peer("--wait-peers", 2, "--join-timeout", 20)
        port = founder.port()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            s.bind(("127.0.0.1", 0))
            s.settimeout(5)
            s.sendto(future(bytes(1190)), ("127.0.0.1", port))
            answer, _ = s.recvfrom(65536)
            self.assertEqual(answer[:2], b"Pd")
            self.assertEqual(answer[2], 0x91, "an answer of its own version, for the newcomer to see")
            self.assertLess(len(answer), 1200)
            founder.wait_for("protocol version differs: 9 in the session, 10 in the newcomer")
            # However often it asks: the log must not fill the disk.
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
                for _ in range(300):
                    other.sendto(future(bytes(1190)), ("127.0.0.1", port))
                    time.sleep(0.005)
            founder.wait_for(r"refused \d+ more")
            self.assertLess(founder.text().count("refused"), 20)
            # The other way round: a joiner is told by a member of the future.
            joiner = self.peer("--join", f"127.0.0.1:{s.getsockname()[1]}")
            _, sender = s.recvfrom(65536)
            s.sendto(future(b"anything"), sender)
            self.assertEqual(joiner.end(), 1)
            self.assertIn("protocol version differs: 10 at 127.0.0.1", joiner.text())


PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS = 24, 38
LIBC = ctypes.CDLL(None)


def without_capabilities():
    """Between fork and exec: whoever runs the program has no capability left, nor can it get one."""
    capability = 0
    while LIBC.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0) == 0:  # fails behind the last, and for who is not root
        capability += 1
    LIBC.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)


class Rights(Case):
    def test_needs_none(self):
        bare = {"preexec_fn": without_capabilities, "env": {**os.environ, "PADR_KEY": "44" * 32}}
        founder = self.peer("--wait-peers", 2, "--duration", 2, **bare)
        joiner = self.peer("--join", f"127.0.0.1:{founder.port()}", "--duration", 2, **bare)
        with open(f"/proc/{founder.process.pid}/status") as f:
            status = dict(line.rstrip("\n").split(":\t", 1) for line in f)
        self.assertEqual((int(status["CapEff"], 16), status["NoNewPrivs"]), (0, "1"))
        self.assertEqual([founder.end(), joiner.end()], [0, 0])
        self.check_agreement([founder, joiner], least_common=2)


class Binding(Case):
    def test_port_in_use(self):
        founder = self.peer("--wait-peers", 2)
        port = founder.port()
        code, _, err = run("--listen", f"127.0.0.1:{port}")
        self.assertEqual(code, 1)
        self.assertRegex(err, rf"cannot listen on 127.0.0.1:{port}: Address already in use")


if __name__ == "__main__":
    main()
