#!/usr/bin/env python3
"""End to end: wrong input as a new user would give it. Each gets one clear line and exit code 2; none a crash.

Usage: peer_usage.py PATH_TO_PADR_PEER [unittest arguments]
"""

import json
import os
import re
import signal
import subprocess
import time

from peers import PATIENCE, PLAYING, PROGRAM, Case, main, run

JOIN = ["--join", "127.0.0.1:9"]


class Usage(Case):
    def check_wrong(self, arguments, *words):
        with self.subTest(arguments=arguments):
            code, out, err = run(*arguments)
            lines = err.strip().splitlines()
            self.assertEqual(code, 2, err)
            self.assertEqual(out, "")
            self.assertEqual(len(lines), 1, err)
            self.assertTrue(lines[0].startswith("padr-peer: "), err)
            for word in words:
                self.assertIn(word, lines[0])

    def test_a_full_disk_is_told_and_costs_nothing_else(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("there is no /dev/full")
        played = ["--wait-peers", 1, "--duration", 1, "--json", "-"]
        with open("/dev/full", "w", encoding="ascii") as full:
            for arguments in (["keygen"], ["fingerprint"], played):
                with self.subTest(arguments=arguments):
                    done = subprocess.run([PROGRAM, *map(str, arguments)], stdout=full, stderr=subprocess.PIPE, text=True)
                    self.assertEqual(done.returncode, 1)
                    self.assertIn("padr-peer: cannot write to standard output: No space left on device", done.stderr)
        for flag in ("--pcap", "--trace"):
            with self.subTest(flag=flag):
                code, summary, said = run(*played, flag, "/dev/full", "--health", os.path.join(self.folder.name, "health"))
                self.assertEqual(code, 1, said)
                self.assertIn(f"{flag}: cannot write '/dev/full': No space left on device: nothing more is", said)
                self.assertIn("ended: played to the end", said)
                self.assertGreater(json.loads(summary)["ticks"], 50)
                self.assertEqual(json.loads(summary)["exit_code"], 1)
                self.assertEqual(os.listdir(self.folder.name), [])

    def test_flags(self):
        table = [
            (["--no-such-flag"], "--no-such-flag"),
            (["extra"], "extra"),
            (["--listen"], "--listen"),
            (["--listen", "127.0.0.1"], "--listen", "no port", "HOST:PORT"),
            (["--listen", "127.0.0.1:x"], "--listen", "not a port"),
            (["--listen", "127.0.0.1:65536"], "--listen", "65535"),
            (["--listen", "::1:7000"], "--listen", "brackets"),
            (["--listen", "no-such-host.invalid:7000"], "--listen", "cannot resolve", "no-such-host.invalid"),
            (["--join", "no-such-host.invalid:7000", "--join-timeout", "0.1"], "--join", "cannot resolve", "no-such-host.invalid"),
            (["--join", "127.0.0.1:0"], "--join", "from 1 to 65535"),
            (["--listen", "0.0.0.0:0"], "--listen", "--insecure"),
            (["--listen", "[::]:0"], "--listen", "--insecure"),
            (["--join", "192.0.2.1:7000"], "--join", "--listen", "--insecure"),
            (["--join", "127.0.0.1:7000", "--join", "192.0.2.1:7000"], "192.0.2.1:7000 is not on this machine", "--listen"),
            (["--join", "127.0.0.1:7000", "--join", "[::1]:7000"], "--join", "::1", "no IPv4"),
            (["--join", "192.0.2.1:7000", "--listen", "127.0.0.1:0"], "loopback", "192.0.2.1:7000"),
            (["--join", "127.0.0.1:7000", "--listen", "[::1]:0"], "--join", "127.0.0.1", "no IPv6", "--listen"),
            (["--join", "[::1]:7000", "--listen", "127.0.0.1:0"], "--join", "::1", "no IPv4", "--listen"),
            (["--wait-peers", "0"], "--wait-peers", "0", "1 to"),
            (["--wait-peers", "65"], "--wait-peers", "65"),
            (["--wait-peers", "many"], "--wait-peers"),
            (["--spectate", "--slots", "2"], "--slots", "3 to"),
            (["--slots", "1"], "--slots", "2 to", "--wait-peers"),
            (["--spectate", "--input", "wander"], "--spectate", "--input"),
            (["--meeting-point", "--crowd"], "--meeting-point", "--crowd"),
            (["--map-port"], "--map-port", "--listen"),
            (["--map-port", "--listen", "127.0.0.1:0"], "--map-port", "loopback"),
            (["--map-port", "--listen", "[2001:db8::1]:0"], "--listen", "--insecure"),
            (["--seed", "010"], "--seed", "'010' is not allowed"),
            (["--duration", "-1"], "--duration"),
            (["--duration", "nan"], "--duration"),
            (["--linger", "1e9"], "--linger"),
            (["--status-interval", "-1"], "--status-interval"),
            (["--seed", "-1"], "--seed"),
            (["--log-level", "loud"], "--log-level", "loud", "debug"),
            (["--log", "net"], "--log", "net"),
            (["--log", "nut=debug"], "--log", "nut", "session"),
            (["--log", "net=loud"], "--log", "loud"),
        ]
        for arguments, *words in table:
            self.check_wrong(arguments, *words)

    def test_an_empty_value_is_not_an_option_that_is_left_out(self):
        for flag in ("--key-file", "--join", "--listen", "--trace", "--json", "--pcap", "--health", "--keylog", "--monitor",
                     "--seal", "--log", "--scenario", "--technique", "--input", "--threshold", "--wait-peers"):  # fmt: skip
            self.check_wrong([flag, ""], flag + ": is empty; give ", "or leave " + flag + " out")
        self.check_wrong(["--json="], "--json: no value; give FILE")
        for flag in ("--pcap", "--trace"):
            self.check_wrong([flag, "-"], flag + ": this cannot be printed; name a file in place of -")
        self.check_wrong(["keygen", ""], "keygen: the name of the file is empty")
        self.assertIn("usage: padr-peer keygen [FILE]", run("keygen", "-h")[1])
        self.check_wrong(["fingerprint", ""], "fingerprint: OTHER is empty")
        line = run("fingerprint")[1].splitlines()[0]
        for other in (line, line.split()[1]):
            code, out, _ = run("fingerprint", other)
            self.assertEqual((code, out.splitlines()[-1]), (0, "the other one's physics is the same"))
        code, _, err = run("--wait-peers", 1, "--duration", 0.1, "--netem", "")
        self.assertEqual(code, 0, err)

    def test_crowd(self):
        table = [
            (["--start", "1,2"], "--start", "--crowd"),
            (["--stroll", "20"], "--stroll", "--crowd"),
            (["--region-side", "24"], "--region-side", "--crowd"),
            (["--crowd", "--scenario", "arena"], "--scenario", "--crowd"),
            (["--crowd", "--wait-peers", "3"], "--wait-peers", "--crowd"),
            (["--crowd", "--slots", "3"], "--slots", "--crowd"),
            (["--crowd", "--join", "127.0.0.1:7", "--join", "127.0.0.1:8"], "--join", "more than once"),
            (["--crowd", "--trace", "x.trace"], "--trace", "--crowd"),
            (["--crowd", "--health", "x.json"], "--health", "--crowd"),
            (["--crowd", "--monitor", "127.0.0.1:9"], "--monitor", "--crowd"),
            (["--crowd", "--netem-to", "1=loss 5%"], "--netem-to", "HOST:PORT"),
            (["--crowd", "--key-file", self.file("key", "0" * 64)], "--crowd", "--key-file"),
            (["--crowd", "--start", "1"], "--start: '1' is not allowed; give X,Y in metres"),
            (["--crowd", "--start", "5,x"], "--start: '5,x' is not allowed; give X,Y in metres"),
            (["--crowd", "--start", "1,2,3"], "--start: '1,2,3' is not allowed; give X,Y in metres"),
            (["--crowd", "--start", "nan,1"], "--start: 'nan,1' is not allowed; give X,Y in metres"),
            (["--crowd", "--start", "1e9,0"], "--start", "less than", "metres"),
            (["--crowd", "--control"], "--control: cannot be used in a crowd"),
            (["--crowd", "--seal", "auth"], "--seal: cannot be used in a crowd"),
            (["--crowd", "--monitor-detail", "live"], "--monitor-detail: cannot be used in a crowd"),
            (["--crowd", "--stroll", "1"], "--stroll"),
            (["--crowd", "--input", "rest", "--stroll", "20"], "--stroll", "--input wander"),
            (["--crowd", "--region-side", "3"], "--region-side"),
            (["--crowd", "--input", "path:/no/such/file.csv"], "--input", "/no/such/file.csv"),
            (["--crowd", "--listen", "0.0.0.0:0"], "--listen", "datagram; give a loopback address, or --insecure"),
            (["--crowd", "--join", "192.0.2.1:7000"], "--join", "give --listen 0.0.0.0:0 and --insecure"),
        ]
        for arguments, *words in table:
            self.check_wrong(arguments, *words)
        path = self.file("far.csv", "t,x,y\n0,500,500\n1,501,500\n2,502,500\n")
        code, _, err = run("--crowd", "--start", "500,500", "--input", f"path:{path}", "--duration", 0.1)
        self.assertEqual(code, 0, err)
        self.assertIn("3 points", err)
        self.assertNotIn("world", err, "the plane has no end")

    def test_technique(self):
        table = [
            (["--technique", "best"], "--technique", "best", "adaptive"),
            (["--threshold", "0"], "--threshold", "metres"),
            (["--threshold", "0.1:0.3"], "--threshold", "HIGH"),
            (["--threshold", "nan"], "--threshold"),
            (["--body-threshold", "-1"], "--body-threshold", "off"),
            (["--model", "third"], "--model", "second"),
            (["--predictor", "oracle"], "--predictor", "lookahead"),
            (["--threshold-law", "three-level"], "--threshold-law"),
            (["--convergence", "jump"], "--convergence"),
            (["--replay", "maybe"], "--replay", "on"),
            (["--precision", "16"], "--precision", "rounded"),
            (["--radius", "0"], "--radius"),
            (["--steps", "1.5"], "--steps"),
            (["--count", "0"], "--count"),
            (["--pcc-bound", "-0.1"], "--pcc-bound"),
        ]
        for arguments, *words in table:
            self.check_wrong(arguments, *words)

    def test_netem(self):
        table = [
            (["--netem", "delay"], "--netem"),
            (["--netem", "delay 100 parsecs"], "--netem", "parsecs"),
            (["--netem", "loss 101%"], "--netem", "101%"),
            (["--netem", "trace /no/such.link"], "--netem", "/no/such.link", "No such file", "mobile"),
            (["--netem", "trace " + self.file("my.link", "5\n10\nten\n")], "--netem", "my.link:3", '"ten"', "milliseconds"),
            (["--netem-to", "1=trace " + self.file("zero.link", "0\n")], "--netem-to 1", "zero.link:1", "1 or later"),
            (["--netem", "trace mobile rate 1mbit"], "--netem", "not allowed with rate"),
            (["--netem-seed", "x"], "--netem-seed"),
            (["--netem-to", "loss 10%"], "--netem-to", "="),
            (["--netem-to", "1=loss 5%", "--netem-to", "1=loss 6%"], "--netem-to", "given twice for 1"),
            (["--monitor-detail", "live"], "--monitor-detail", "--monitor"),
            (["--netem-to", "64=loss 10%"], "--netem-to", "0 to 63"),
            (["--netem-to", "1=loss much"], "--netem-to 1", "much"),
            (["--netem-to", "nowhere=loss 1%"], "--netem-to", "HOST:PORT"),
            (["--netem-to", "no-such-host.invalid:1=loss 1%"], "--netem-to", "cannot resolve"),
        ]
        for arguments, *words in table:
            self.check_wrong(arguments, *words)

    def test_scenario(self):
        broken = self.file("broken.textproto", 'name: "x"\nbodies {\n')
        odd = self.file("odd.textproto", 'name: "x"\nwidgets: 3\n')
        binary = self.file("binary.textproto", bytes(range(256)))
        self.check_wrong(["--scenario", "atlantis"], "--scenario", "atlantis", "arena")
        self.check_wrong(["--scenario", self.folder.name], "--scenario", "directory")
        self.check_wrong(["--scenario", broken], broken + ":")
        self.check_wrong(["--scenario", odd], odd + ":2", "widgets")
        self.check_wrong(["--scenario", binary], binary)
        with open(os.path.join(os.path.dirname(__file__), "../../common/scenarios/arena.textproto"), encoding="utf-8") as file:
            arena = file.read()
        latin = self.file("latin.textproto", re.sub("^name: .*", r'name: "\\377"', arena, flags=re.MULTILINE))
        self.check_wrong(["--scenario", latin], latin + ": name is not well-formed, allowed: UTF-8")

    def test_paths(self):
        table = [
            ("nan.csv", "t,x,y\n0,1,1\n1,nan,2\n", ":3"),
            ("inf.csv", "t,x,y\n0,1,1\n1,2,inf\n", ":3"),
            ("unsorted.csv", "t,x,y\n0,1,1\n2,2,2\n1,3,3\n", ":4"),
            ("one_column.csv", "t\n0\n1\n", ":1"),
            ("words.csv", "t,x,y\n0,one,two\n", ":2"),
            ("empty.csv", "", ""),
            ("header_only.csv", "t,x,y\n", ""),
            ("binary.csv", bytes(range(256)), ""),
        ]
        for name, content, where in table:
            path = self.file(name, content)
            self.check_wrong(["--input", f"path:{path}"], "--input", path + where)
        missing = os.path.join(self.folder.name, "missing.csv")
        self.check_wrong(["--input", f"path:{missing}"], "--input", missing, "No such file")
        self.check_wrong(["--input", f"path:{self.folder.name}"], "--input", "directory")
        self.check_wrong(["--input", "path:"], "--input", "names no file")
        self.check_wrong(["--input", "mouse"], "--input", "mouse", "wander")
        self.check_wrong(["--input", "wander:-1"], "--input", "wander")

    def test_files_that_cannot_be_written(self):
        nowhere = os.path.join(self.folder.name, "no", "such", "folder.trace")
        for flag in ("--trace", "--json", "--pcap"):
            self.check_wrong([flag, nowhere, "--wait-peers", 1, "--duration", 0.1], flag, nowhere)

    def test_help_and_version(self):
        code, out, err = run("--help")
        self.assertEqual((code, err), (0, ""))
        for word in ["--listen", "--join", "--netem-to", "--body-threshold", "Exit code", "padr-peer --join", "[::1]:7001"]:
            self.assertIn(word, out)
        self.assertLess(max(len(line) for line in out.splitlines()), 200)
        code, out, err = run("--version")
        self.assertEqual((code, err), (0, ""))
        self.assertRegex(out, r"^padr-peer \d+\.\d+\.\d+ \(revision .+\)$")

    def test_what_is_legal_but_doubtful_is_warned_of(self):
        code, _, err = run("--wait-peers", 1, "--duration", 0.1, "--netem", "delay 100")
        self.assertEqual(code, 0)
        self.assertRegex(err, r"warning .*--netem: .*microseconds")
        code, _, err = run(*JOIN, "--wait-peers", 3, "--join-timeout", 0.3)
        self.assertEqual(code, 1)
        self.assertRegex(err, "--wait-peers is only for the founder")
        key = ("--wait-peers", 1, "--duration", 0.1, "--key-file", self.file("key", "0" * 64), "--insecure")
        self.assertRegex(run(*key)[2], "--insecure has no meaning in a session with a key")
        _, _, err = run(*key, "--control", "--monitor", "127.0.0.1:9")
        self.assertNotIn("--insecure", err, "it lets a monitor on another machine control the peer")


class Signals(Case):
    # Ctrl-C goes to both ends of `padr-peer ... 2>&1 | tee log`.
    def test_a_reader_that_ends_takes_nothing_along(self):
        files = [os.path.join(self.folder.name, name) for name in ("peer.json", "peer.trace")]
        with subprocess.Popen([PROGRAM, "--wait-peers", "1", "--json", files[0], "--trace", files[1]],
                              stderr=subprocess.PIPE, text=True) as peer:  # fmt: skip
            while not re.search(PLAYING, peer.stderr.readline()):
                self.assertIsNone(peer.poll())
            peer.stderr.close()
            time.sleep(1.5)  # a status line fails
            peer.send_signal(signal.SIGINT)
            self.assertEqual(peer.wait(PATIENCE), 0)
        with open(files[0], encoding="utf-8") as f:
            self.assertEqual(json.load(f)["reason"], "stopped")
        self.assertGreater(os.path.getsize(files[1]), 0)

    def test_a_closed_terminal_is_a_reason_to_leave_unless_nohup_says_otherwise(self):
        for nohup in (False, True):
            with self.subTest(nohup=nohup):
                ignore = (lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) if nohup else None
                peer = self.peer("--wait-peers", 1, preexec_fn=ignore)
                peer.wait_for(PLAYING)
                peer.process.send_signal(signal.SIGHUP)
                if nohup:
                    time.sleep(0.5)
                    self.assertIsNone(peer.process.poll())
                    peer.process.send_signal(signal.SIGINT)
                self.assertEqual(peer.end(), 0)
                self.assertEqual(peer.summary()["reason"], "stopped")

    # It may have been admitted already. Once, the founder counted it, began, and played on alone.
    def test_who_is_told_to_leave_while_it_comes_in_says_goodbye(self):
        founder = self.peer("--wait-peers", 3)
        joiner = self.peer("--join", f"127.0.0.1:{founder.port()}")
        joiner.wait_for("welcomed")
        joiner.process.send_signal(signal.SIGINT)
        founder.wait_for("peer 1 has left")
        self.assertEqual(joiner.end(), 1)
        joiner.wait_for("ended: SIGINT before the session started")
        founder.process.send_signal(signal.SIGINT)
        founder.end()


if __name__ == "__main__":
    main()
