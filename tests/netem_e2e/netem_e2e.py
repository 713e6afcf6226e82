#!/usr/bin/env python3
"""End to end: padr-netem as a process between real UDP sockets on loopback.

Usage: netem_e2e.py PATH_TO_PADR_NETEM [unittest arguments]

Times are checked from below only, as a loaded machine may be late but never early; everything that waits has a bound.
"""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = "padr-netem"
PATIENCE = 5.0  # s until something that should arrive counts as missing
SILENCE = 0.3  # s after which nothing more is expected


def udp(host="127.0.0.1"):
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    s = socket.socket(family, socket.SOCK_DGRAM)
    s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    s.bind((host, 0))
    s.settimeout(PATIENCE)
    return s


def drain(s, count=None):
    """Datagrams until `count` have come, or until silence: [(bytes, sender, time)]."""
    got = []
    s.settimeout(PATIENCE if count else SILENCE)
    while count is None or len(got) < count:
        try:
            data, sender = s.recvfrom(65536)
        except socket.timeout:
            break
        got.append((data, sender, time.monotonic()))
    return got


class Relay:
    """A running padr-netem; `ports` are those it listens on, in the order of its links."""

    def __init__(self, *arguments, links):
        command = [PROGRAM]
        for link in links:
            command += ["--link", link]
        command += [str(a) for a in arguments]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.ports, self.log = [], []
        while len(self.ports) < len(links):
            line = self.process.stderr.readline()
            if not line:
                raise AssertionError("padr-netem ended: " + "".join(self.log))
            self.log.append(line)
            found = re.search(r":(\d+) -> .* there .* back ", line)
            if found:
                self.ports.append(int(found[1]))

    def end(self, how=signal.SIGTERM):
        """Stops it; its exit code, and the numbers of its last line for each link."""
        self.process.send_signal(how)
        out, err = self.process.communicate(timeout=PATIENCE)
        self.log.append(err)
        lines = [line for line in out.splitlines() if " end " in line]
        stats = []
        for line in lines:
            _, there, back = line.split(" | ")
            numbers = lambda text: {k: int(v) for k, v in re.findall(r"([a-z-]+) (\d+)", text)}
            stats.append({"all": numbers(line.split(" | ")[0]), "there": numbers(there), "back": numbers(back)})
        return self.process.returncode, stats

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


class Case(unittest.TestCase):
    def setUp(self):
        self.target = udp()
        self.client = udp()

    def tearDown(self):
        self.target.close()
        self.client.close()

    def relay(self, *arguments, links=None):
        return Relay(*arguments, links=links or [f"127.0.0.1:0=127.0.0.1:{self.target.getsockname()[1]}"])

    def send(self, relay, data, client=None):
        (client or self.client).sendto(data, ("127.0.0.1", relay.ports[0]))

    def survivors(self, count, *arguments):
        with self.relay(*arguments) as relay:
            for i in range(count):
                self.send(relay, b"%d" % i)
            return [int(data) for data, _, _ in drain(self.target)]


class Forwarding(Case):
    def test_replies_reach_the_client_they_belong_to(self):
        clients = [self.client, udp(), udp()]
        with self.relay() as relay:
            for i, client in enumerate(clients):
                self.send(relay, b"from %d" % i, client)
            for data, sender, _ in drain(self.target, len(clients)):
                self.target.sendto(b"to " + data[5:], sender)
            for i, client in enumerate(clients):
                self.assertEqual([d for d, _, _ in drain(client, 1)], [b"to %d" % i])
                self.assertEqual(drain(client), [])
            code, stats = relay.end()
        for client in clients[1:]:
            client.close()
        self.assertEqual(code, 0)
        self.assertEqual(stats[0]["all"]["clients"], 3)
        self.assertEqual((stats[0]["there"]["in"], stats[0]["there"]["out"]), (3, 3))
        self.assertEqual((stats[0]["back"]["in"], stats[0]["back"]["out"]), (3, 3))

    def test_any_size_that_udp_allows(self):
        with self.relay() as relay:
            for size in (0, 1, 1200, 9000, 65507):
                self.send(relay, b"x" * size)
                self.assertEqual([len(d) for d, _, _ in drain(self.target, 1)], [size])

    def test_names_and_ipv6(self):
        try:
            target = udp("::1")
        except OSError:
            self.skipTest("no IPv6 here")
        with target, udp("::1") as client:
            with self.relay(links=[f"[::1]:0=[::1]:{target.getsockname()[1]}",
                                   f"localhost:0=localhost:{self.target.getsockname()[1]}"]) as relay:
                client.sendto(b"six", ("::1", relay.ports[0]))
                self.assertEqual([d for d, _, _ in drain(target, 1)], [b"six"])
                self.client.sendto(b"four", ("127.0.0.1", relay.ports[1]))
                self.assertEqual([d for d, _, _ in drain(self.target, 1)], [b"four"])

    def test_target_may_come_up_late(self):
        address = self.target.getsockname()
        self.target.close()
        with self.relay(links=[f"127.0.0.1:0=127.0.0.1:{address[1]}"]) as relay:
            for _ in range(5):
                self.send(relay, b"nobody listens")
                time.sleep(0.02)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as late:
                late.bind(address)
                self.send(relay, b"now")
                self.assertEqual([d for d, _, _ in drain(late, 1)], [b"now"])

    def test_clients_are_bounded_and_forgotten(self):
        with self.relay("--max-clients", 1, "--client-idle", 0.2) as relay, udp() as second:
            self.send(relay, b"first")
            self.assertEqual(len(drain(self.target, 1)), 1)
            self.send(relay, b"refused", second)
            self.assertEqual(drain(self.target), [])
            deadline = time.monotonic() + PATIENCE  # idle clients are swept once a second
            got = []
            while not got and time.monotonic() < deadline:
                self.send(relay, b"second", second)
                got = drain(self.target)
            self.assertEqual(got[0][0], b"second")
            _, stats = relay.end()
        self.assertEqual(stats[0]["all"]["clients"], 1)
        self.assertGreaterEqual(stats[0]["all"]["refused"], 1)
        self.assertEqual(stats[0]["there"]["in"], stats[0]["there"]["out"])  # those of the first client still count


class Impairments(Case):
    def test_delay_each_way(self):
        with self.relay("--netem", "delay 80ms", "--netem-back", "delay 40ms") as relay:
            for _ in range(3):
                start = time.monotonic()
                self.send(relay, b"ping")
                data, sender, there = drain(self.target, 1)[0]
                self.target.sendto(b"pong", sender)
                back = drain(self.client, 1)[0][2]
                self.assertGreaterEqual(there - start, 0.080)
                self.assertGreaterEqual(back - there, 0.040)
                self.assertLess(back - start, 2.0)

    def test_loss_of_everything_is_counted(self):
        with self.relay("--netem", "loss 100%") as relay:
            for _ in range(10):
                self.send(relay, b"x")
            self.assertEqual(drain(self.target), [])
            _, stats = relay.end()
        self.assertEqual((stats[0]["there"]["in"], stats[0]["there"]["lost"]), (10, 10))

    def test_seed_repeats_the_losses(self):
        spec = ("--netem", "loss 30%")
        first = self.survivors(300, *spec, "--seed", 5)
        self.assertEqual(first, self.survivors(300, *spec, "--seed", 5))
        self.assertNotEqual(first, self.survivors(300, *spec, "--seed", 6))
        # 6 standard deviations of a binomial about 210
        self.assertLess(abs(len(first) - 210), 48)

    def test_corruption_is_one_bit(self):
        sent = bytes(range(64))
        with self.relay("--netem", "corrupt 100%") as relay:
            for _ in range(20):
                self.send(relay, sent)
            got = drain(self.target, 20)
        self.assertEqual(len(got), 20)
        for data, _, _ in got:
            self.assertEqual(sum(bin(a ^ b).count("1") for a, b in zip(data, sent)), 1)

    def test_duplicates(self):
        self.assertEqual(self.survivors(20, "--netem", "duplicate 100%"), [i for i in range(20) for _ in range(2)])

    def test_jitter_reorders_and_loses_nothing(self):
        got = self.survivors(200, "--netem", "delay 100ms 50ms")
        self.assertEqual(sorted(got), list(range(200)))
        self.assertNotEqual(got, sorted(got))

    def test_rate_is_kept_and_so_is_the_order(self):
        with self.relay("--netem", "rate 1mbit delay 20ms 20ms") as relay:
            start = time.monotonic()
            for i in range(50):
                self.send(relay, (b"%d" % i).ljust(972))  # 1,000 bytes with headers: 8 ms each
            got = drain(self.target, 50)
        self.assertEqual([int(d) for d, _, _ in got], list(range(50)))
        for i, (_, _, at) in enumerate(got):
            self.assertGreaterEqual(at - start, 0.008 * (i + 1))

    def test_link_trace_has_packets_wait_for_opportunities(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "my.link")
            with open(path, "w", encoding="ascii") as f:
                f.write("".join(f"{ms}\n" for ms in range(20, 401, 20)))
            with self.relay("--netem", f"trace {path}", "--netem-back", "trace satellite random") as relay:
                time.sleep(0.1)  # opportunities that nobody uses
                start = time.monotonic()
                for i in range(40):
                    self.send(relay, (b"%d" % i).ljust(724))  # 752 bytes with headers: two in an opportunity
                got = drain(self.target, 40)
                relay.end()
        self.assertEqual([int(d) for d, _, _ in got], list(range(40)))
        # The first may come at once, every other pair 20 ms after the one before.
        for i, (_, _, at) in enumerate(got):
            self.assertGreaterEqual(at - start, 0.020 * (i // 2) - 0.020)

    def test_one_link_may_differ(self):
        port = self.target.getsockname()[1]
        with udp() as spare:
            free = spare.getsockname()[1]
        links = [f"127.0.0.1:0=127.0.0.1:{port}", f"127.0.0.1:{free}=127.0.0.1:{port}"]
        with self.relay("--netem-for", f"127.0.0.1:{free}=loss 100%", links=links) as relay:
            self.client.sendto(b"lost", ("127.0.0.1", relay.ports[1]))
            self.send(relay, b"kept")
            self.assertEqual([d for d, _, _ in drain(self.target)], [b"kept"])


class Process(Case):
    def run_once(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=PATIENCE * 2, check=False)
        return done.returncode, done.stdout, done.stderr

    def test_ends_cleanly_on_signals(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            with self.relay("--netem", "delay 3s") as relay:
                self.send(relay, b"held at the end")
                time.sleep(0.1)
                code, stats = relay.end(how)
            self.assertEqual(code, 0)
            self.assertEqual((stats[0]["there"]["in"], stats[0]["there"]["held"]), (1, 1))

    def test_duration_and_statistics(self):
        code, out, _ = self.run_once("--link", "127.0.0.1:0=127.0.0.1:9", "--duration", "0.35", "--stats-interval", "0.1")
        self.assertEqual(code, 0)
        self.assertGreaterEqual(out.count(" now "), 1)
        self.assertEqual(out.count(" end "), 1)

    def test_a_full_disk_is_told(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("there is no /dev/full")
        played = ("--link", "127.0.0.1:0=127.0.0.1:9", "--stats-interval", "0.1", "--duration", "20")
        with open("/dev/full", "w", encoding="ascii") as full:
            for arguments in (("--help",), ("--version",), played):
                with self.subTest(arguments=arguments):
                    done = subprocess.run([PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, timeout=PATIENCE)
                    self.assertEqual(done.returncode, 1)
                    self.assertIn("padr-netem: cannot write to standard output: No space left on device", done.stderr)

    def test_several_links_may_have_any_free_port(self):
        link = ("--link", "127.0.0.1:0=127.0.0.1:9")
        code, out, err = self.run_once(*link, *link, "--duration", "0.1")
        self.assertEqual(code, 0, err)
        self.assertEqual(out.count(" end "), 2)

    def test_usage_errors_are_one_line_and_exit_2(self):
        link = ("--link", "127.0.0.1:0=127.0.0.1:9")
        for arguments, says in (
            ((), "--link"),
            (("--link", "nonsense"), "LISTEN=TARGET"),
            (("--link", "127.0.0.1:5=127.0.0.1:5"), "relay to itself"),
            (("--link", "localhost:5=127.0.0.1:5"), '--link: "localhost:5=127.0.0.1:5" would relay to itself'),
            (("--link", "127.0.0.1:2961=127.0.0.1:2962", "--link", "127.0.0.1:2962=127.0.0.1:2961"), "would relay in a circle"),
            (("--link", "0.0.0.0:5=127.0.0.1:5"), "relay to itself"),
            (("--link", "[::]:5=127.0.0.1:5"), "relay to itself"),
            (("--link", "127.0.0.1:5=0.0.0.0:5"), "relay to itself"),
            ((*link, "--netem-for", "127.0.0.1:0=loss 1%", "--netem-for", "127.0.0.1:0=loss 2%"), "--netem-for: given twice for 127.0.0.1:0; give it once"),
            (("--link", "127.0.0.1:5=127.0.0.1:9", "--link", "127.0.0.1:5=127.0.0.1:10"), "two of them listen"),
            ((*link, "--seed", "-1"), "whole number"),
            (("--link", "127.0.0.1:0=127.0.0.1"), "HOST:PORT"),
            (("--link", "127.0.0.1:0=127.0.0.1:70000"), "1 to 65535"),
            (("--link", "127.0.0.1:0=::1:9"), "brackets"),
            (("--link", "127.0.0.1:0=no-such-host.invalid:9"), 'cannot resolve "no-such-host.invalid"'),
            ((*link, "--netem", "delay 5parsecs"), 'word 2 "5parsecs"'),
            ((*link, "--netem-back", "loss 101"), "--netem-back: word 2"),
            ((*link, "--netem", "trace no/such/file"), "not one of mobile, satellite, uplink; as a file: cannot read 'no/such/file'"),
            ((*link, "--netem-back", "trace mobile rate 1mbit"), "--netem-back: word 1"),
            ((*link, "--netem-for", "127.0.0.1:5=loss 1%"), "no --link listens"),
            ((*link, "--seed", "x"), "--seed"),
            ((*link, "--bogus"), "--bogus"),
        ):
            with self.subTest(arguments=arguments):
                code, out, err = self.run_once(*arguments)
                self.assertEqual(code, 2)
                self.assertEqual(out, "")
                self.assertEqual(err.count("\n"), 1, err)
                self.assertIn(says, err)

    def test_port_in_use_is_exit_1(self):
        port = self.target.getsockname()[1]
        code, _, err = self.run_once("--link", f"127.0.0.1:{port}=127.0.0.1:9")
        self.assertEqual(code, 1)
        self.assertIn(f"cannot listen on 127.0.0.1:{port}: Address already in use", err)
        self.assertEqual(err.count("\n"), 1, err)

    def test_help_has_an_example(self):
        code, out, _ = self.run_once("--help")
        self.assertEqual(code, 0)
        self.assertIn("Example:", out)

    def test_doubtful_times_are_pointed_out(self):
        with self.relay("--netem", "delay 100") as relay:
            relay.end()
            self.assertIn("100ms if milliseconds are meant", "".join(relay.log))


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main(verbosity=2)
