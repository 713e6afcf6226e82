#!/usr/bin/env python3
"""tools/demo.sh with programs that only sleep: what it does when processes come up late, and what it refuses.

Usage: demo_test.py REPOSITORY [unittest arguments]
"""

import fcntl
import os
import pty
import re
import select
import socket
import subprocess
import time
import unittest

from stand_in import PATIENCE, REPOSITORY, Case

# The one that is only tried has the slots of all.
PEER = """#!/bin/sh
case "$*" in
  *dely*) echo "padr-peer: --netem: no word is dely" >&2; exit 2 ;;
  *--slots*) exit 0 ;;
esac
echo "$@" >>"$SEEN"
while [ "$1" != --duration ]; do shift; done
exec sleep "$2"
"""
MONITOR = """#!/bin/sh
echo "peers: padr-peer --monitor 127.0.0.1:4321" >&2
echo "http://127.0.0.1:1234/"
exec sleep 60
"""
# Every process whose program is named by way of $bin takes a while before it opens its files: the subscript is evaluated
# where the name is expanded, in that process.
LATE = "declare -n bin='late[$(sleep 0.3)0]'\n"


class Demo(Case):
    def setUp(self):
        super().setUp()
        self.borrow("tools/demo.sh")
        self.borrow("common/model/technique.cpp")
        self.put("tools/deps.sh", "#!/bin/sh\n")
        self.put("bin/cmake", "#!/bin/sh\n")
        self.put("build/release/bin/padr-peer", PEER)
        self.put("build/release/bin/padr-monitor", MONITOR)
        self.put("build/release/bin/padr-report", "#!/bin/sh\n")
        self.put("late", LATE)

    def demo(self, *arguments, **more):
        return self.run_script("tools/demo.sh", "--duration", "1", *arguments, SEEN=self.path("seen"), **more)

    def test_plays_and_reports(self):
        done = self.demo()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("Look and play along:  http://127.0.0.1:1234/", done.stdout)
        self.assertTrue(done.stdout.endswith("All confirmed worlds were identical.\n"), done.stdout)
        self.assertEqual(self.text("seen").count("--monitor 127.0.0.1:4321 --control"), 4)

    def test_logs_of_processes_that_come_up_late_are_waited_for(self):
        done = self.demo(BASH_ENV=self.path("late"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(done.stdout.endswith("All confirmed worlds were identical.\n"), done.stdout)

    def test_so_are_they_in_a_terminal(self):
        ours, theirs = pty.openpty()
        process = subprocess.Popen(["tools/demo.sh", "--duration", "1", "--page", "off"], cwd=self.folder, stdin=theirs,
                                   stdout=theirs, stderr=theirs,
                                   env=self.environment(BASH_ENV=self.path("late"), SEEN=self.path("seen")))  # fmt: skip
        os.close(theirs)
        said, deadline = b"", time.monotonic() + PATIENCE
        while time.monotonic() < deadline and select.select([ours], [], [], PATIENCE)[0]:
            try:
                said += os.read(ours, 4096)
            except OSError:  # nobody has the other end any more
                break
        os.close(ours)
        self.assertEqual(process.wait(PATIENCE), 0, said.decode())
        self.assertIn(b"All confirmed worlds were identical.", said)

    def test_a_monitor_that_ends_is_told_of(self):
        self.put("build/release/bin/padr-monitor", "#!/bin/sh\necho no such address >&2\nexit 1\n")
        for more in ({}, {"BASH_ENV": self.path("late")}):
            done = self.demo(**more)
            self.assertEqual(done.returncode, 1)
            self.assertIn("no such address\ndemo.sh: there is no page;", done.stderr)

    def test_a_port_that_is_taken_is_told_of_before_anything_is_built(self):
        self.put("tools/deps.sh", "#!/bin/sh\necho built >&2\n")
        with socket.create_server(("127.0.0.1", 0)) as other:
            port = str(other.getsockname()[1])
            done = self.demo("--page", port)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"demo.sh: --page '{port}': another program listens there; give another port, 0 for any free "
                         "one, or off (see --help)\n")  # fmt: skip
        self.assertEqual(self.demo("--page", port).returncode, 0, "now it is free")

    def test_takes_every_technique_that_there_is(self):
        with open(os.path.join(REPOSITORY, "common/model/technique.cpp"), encoding="utf-8") as f:
            names = re.findall(r'"([^"]*)"', re.search(r"technique_names\(\) \{(.*?)\}", f.read(), re.DOTALL)[1])
        self.assertIn("everything", names)
        help_text = self.demo("--help").stdout
        for name in names:
            self.assertIn(name, help_text)
            done = self.demo("--technique", name, "--peers", "0")
            self.assertIn("--peers '0'", done.stderr, "the technique is no reason to refuse it")
        for name in ("best", "full everything", ""):
            done = self.demo("--technique", name)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr, f"demo.sh: --technique '{name}': must be one of: {' '.join(names)} (see --help)\n")

    # A folder of that name was taken for the scenario.
    def test_the_programs_find_a_scenario_as_without_the_script(self):
        os.mkdir(self.path("arena"))
        self.assertEqual(self.demo("--page", "off").returncode, 0)
        self.assertIn("--scenario arena --seed", self.text("seen"))
        self.put("below/own.json", "{}")
        self.put("build/release/bin/padr-peer", PEER.replace('echo "$@"', "pwd"))
        done = self.run_script("sh", "-c", "cd below && ../tools/demo.sh --duration 1 --page off --scenario own.json",
                               SEEN=self.path("seen"))  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(self.text("seen").endswith("/below\n"))
        self.assertIn("\ntraces: out/demo/peer*.trace\n", done.stdout)

    def test_scenes_are_the_papers_stories(self):
        for name in ("ball", "dominoes", "van", "proxy"):
            self.borrow(f"common/scenarios/paths/{name}.csv")
        for scene, flags, path in [
            ("stop-short", "--scenario ball --seed 1 --technique avatar-only --threshold 0.8 ", "ball.csv,loop"),
            ("predictor", "--scenario dominoes --seed 1 --technique avatar-only --threshold 0.8:0.3 --predictor pcc ",
             "dominoes.csv,loop"),
            ("proxy", "--scenario proxy --seed 1 --technique adaptive ", "proxy.csv"),
        ]:  # fmt: skip
            self.put("seen", "")
            self.assertEqual(self.demo("--page", "off", "--scene", scene).returncode, 0)
            peers = sorted(self.text("seen").splitlines(), key=lambda line: "--join" in line)
            self.assertEqual(len(peers), 2)
            for peer in peers:
                self.assertIn(flags, peer)
                self.assertNotIn("--netem", peer)
            self.assertRegex(peers[0], rf"--input path:\S*/common/scenarios/paths/{re.escape(path)} ")
            self.assertIn("--input rest ", peers[1])

    def test_flags_beside_a_scene_count(self):
        self.borrow("common/scenarios/paths/van.csv")
        done = self.demo("--page", "off", "--technique", "full", "--scene=stop-short", "--scenario", "van", "--peers", "3")
        self.assertEqual(done.returncode, 0, done.stderr)
        peers = self.text("seen").splitlines()
        self.assertEqual(len(peers), 3)
        for peer in peers:
            self.assertIn("--scenario van --seed 1 --technique full --input ", peer)

    def test_a_page_is_open_before_the_chain_begins(self):
        self.borrow("common/scenarios/paths/proxy.csv")
        self.assertEqual(self.demo("--scene", "proxy").returncode, 0)
        self.assertRegex(self.text("out/demo/path.csv"), r"^t,x,y\n0,[\d.,]*\n20\.000000,")

    def test_installed_it_neither_installs_nor_builds(self):
        with open(os.path.join(REPOSITORY, "tools/demo.sh"), encoding="utf-8") as f:
            self.put("usr/bin/padr-demo", f.read())
        with open(os.path.join(REPOSITORY, "common/scenarios/paths/ball.csv"), encoding="utf-8") as f:
            self.put("usr/share/padr/paths/ball.csv", f.read())
        for name, text in (("peer", PEER), ("monitor", MONITOR), ("report", "#!/bin/sh\n")):
            self.put("usr/bin/padr-" + name, text)
        self.put("bin/cmake", "#!/bin/sh\nexit 1\n")
        self.put("tools/deps.sh", "#!/bin/sh\nexit 1\n")
        done = self.run_script("usr/bin/padr-demo", "--duration", "1", "--scene", "stop-short", SEEN=self.path("seen"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotIn("building", done.stdout)
        self.assertIn("Look and play along:  http://127.0.0.1:1234/", done.stdout)
        self.assertIn("to see it again: padr-monitor --trace out/demo", done.stdout)
        self.assertIn("/usr/share/padr/paths/ball.csv,loop", self.text("seen"))
        refused = self.run_script("usr/bin/padr-demo", "--peers", "1")
        self.assertEqual(refused.stderr, "padr-demo: --peers '1': must be a whole number from 2 to 64 (see --help)\n")

    def test_what_a_peer_refuses_leaves_the_older_recording(self):
        self.put("out/demo/.padr-demo", "")
        self.put("out/demo/peer0.trace", "older")
        done = self.demo("--netem", "dely 50ms")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, "padr-peer: --netem: no word is dely\n")
        self.assertEqual(self.text("out/demo/peer0.trace"), "older")
        done = self.demo()
        self.assertIn("the recording in out/demo gives way to a new one", done.stdout)
        self.assertFalse(os.path.exists(self.path("out/demo/peer0.trace")))

    def test_a_folder_with_files_of_others_is_refused(self):
        for n, name in enumerate(("csv/letter.csv", "plots/photo.png", "report.json", "page", "path.csv", "peer0.trace")):
            self.put(f"{n}/{name}", "mine")
            done = self.demo("--out", str(n))
            self.assertEqual(done.returncode, 2, name)
            self.assertEqual(done.stderr, f"demo.sh: --out '{os.path.realpath(self.path(str(n)))}' has files, and no .padr-demo, so "
                             "that they are no demo's; name another folder (see --help)\n")  # fmt: skip
            self.assertEqual(self.text(f"{n}/{name}"), "mine")
        os.mkdir(self.path("empty"))
        self.assertEqual(self.demo("--page", "off", "--out", "empty").returncode, 0)
        self.assertEqual(self.demo("--page", "off", "--out", "empty").returncode, 0, "it is a demo's now")

    # The first one's report was about the traces of both.
    def test_one_demo_at_a_time_writes_to_a_folder(self):
        self.put("out/demo/.padr-demo", "")
        with open(self.path("out/demo/.padr-demo"), "w", encoding="utf-8") as first:
            fcntl.flock(first, fcntl.LOCK_EX)
            done = self.demo()
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"demo.sh: --out '{os.path.realpath(self.path('out/demo'))}': another demo is writing there; "
                         "name another folder, or wait until it has ended (see --help)\n")  # fmt: skip
        self.put("build/release/bin/padr-report", "#!/bin/sh\nflock --nonblock out/demo/.padr-demo echo free || echo held\n")
        self.assertIn("\nheld\n", self.demo("--page", "off").stdout)

    def test_reports_of_whoever_has_come_back_too(self):
        self.put("build/release/bin/padr-peer", PEER.replace("exec", ": >out/demo/peer0.trace; : >out/demo/peer0.2.trace; exec"))
        self.put("build/release/bin/padr-report", "#!/bin/sh\necho of $(basename -a $1 $2)\n")
        self.assertIn("\nof peer0.2.trace peer0.trace\n", self.demo("--page", "off").stdout)

    def test_refuses_other_scenes(self):
        for flags, said in [(["--scene", "ball"], "--scene 'ball': must be one of: stop-short predictor proxy"),
                            (["--scene", "proxy", "--scenario", "arena"], "--scene proxy: --scenario must be one of:")]:  # fmt: skip
            done = self.demo(*flags)
            self.assertEqual(done.returncode, 2)
            self.assertIn(said, done.stderr)


if __name__ == "__main__":
    unittest.main()
