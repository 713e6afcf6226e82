#!/usr/bin/env python3
"""What docker-compose.yml and tools/compose make of the environment, and tools/compose/image/peer.sh of that.

Usage: compose_test.py REPOSITORY [unittest arguments]
"""

import contextlib
import fcntl
import os
import re
import shutil
import subprocess
import threading
import time
import unittest

from stand_in import PATIENCE, REPOSITORY, Case

try:
    import yaml
except ImportError:
    yaml = None

ASYMMETRIC = "tools/compose/asymmetric.yml"
CROWD = "tools/compose/crowd.yml"


class Compose(Case):
    def setUp(self):
        super().setUp()
        self.borrow("tools/compose/image/peer.sh")
        self.put("bin/padr-peer", '#!/bin/sh\nprintf "%s\\n" "$@"\n')
        self.put("bin/getent", "#!/bin/sh\n")
        os.mkdir(self.path("data"))

    def peer(self, number, **environment):
        """The words with which a container starts its peer."""
        done = self.run_script("tools/compose/image/peer.sh", PADR_DATA=self.path("data"), PADR_NUMBER=str(number), **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split("\n")

    def netem(self, number, **environment):
        words = self.peer(number, **environment)
        return words[words.index("--netem") + 1] if "--netem" in words else None

    # An empty one was taken for none.
    def test_a_peers_own_impairment_counts_before_that_of_all(self):
        self.assertEqual(self.netem(3, PADR_NETEM="delay 5ms"), "delay 5ms")
        self.assertEqual(self.netem(3, PADR_NETEM="delay 5ms", PADR_NETEM_3="loss 1%", PADR_NETEM_1=""), "loss 1%")
        self.assertIsNone(self.netem(3, PADR_NETEM="delay 5ms", PADR_NETEM_3=""))
        self.assertIsNone(self.netem(3, PADR_NETEM=""))
        self.assertIsNone(self.netem(3))

    # Captures of who had come back stayed, and were held against the traces of another session.
    def test_a_new_session_begins_without_files_of_an_older_one(self):
        others = {"peer10.trace", "peer2.json", "peer1.pcap", "report"}
        for name in {"peer1.trace", "peer1.back1.trace", "peer1.json", "peer1.back1.json", "peer1.pcapng", "peer1.back2.pcapng",
                     "peer1.health"} | others:  # fmt: skip
            self.put(f"data/{name}", "")
        self.peer(1)
        self.assertEqual(set(os.listdir(self.path("data"))), others | {".founded", ".peer1.lock", "peer1.health"})

    def tell_health(self, number, age=0):
        """That peer's health file, as one that plays writes it once a second."""
        name, new = (self.path("data", f"peer{number}.{end}") for end in ("health", "health.new"))
        self.put(new, '{\n  "healthy": true,\n  "playing": true,\n  "present": 4\n}\n')
        os.utime(new, (time.time() - age,) * 2)
        os.replace(new, name)

    @contextlib.contextmanager
    def playing(self, number):
        """Meanwhile that peer plays."""
        stop = threading.Event()

        def play():
            while not stop.wait(0.2):
                self.tell_health(number)

        self.tell_health(number, age=1)
        thread = threading.Thread(target=play)
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()

    def test_who_comes_back_joins_one_that_lives(self):
        self.tell_health(1, age=1)
        self.tell_health(2, age=2)
        self.put("data/peer1.trace", "of the life before")
        with self.playing(3):
            words = self.peer(1)
        self.assertEqual(words[words.index("--join") + 1], "peer3:7001")
        self.assertEqual(words[words.index("--trace") + 1], self.path("data/peer1.back1.trace"))
        self.assertNotIn("true", self.text("data/peer1.health"), "the health check would take the former life for this one")

    # After `kill` and `up` each peer took the files for a session, and all waited for one another.
    def test_files_of_the_killed_are_no_session(self):
        for number in (1, 2, 3, 4):
            self.tell_health(number, age=1)
        self.assertIn("--wait-peers", self.peer(1))

    # Who came a second after the founder kept the files of the session before, and the report had two sessions in it.
    def test_who_comes_late_begins_without_files_of_an_older_session(self):
        for name in ["peer2.trace", "peer2.back1.trace", "peer2.json", "peer2.back1.pcapng", "peer22.trace", "peer1.trace"]:
            self.put(f"data/{name}", "of the session before")
            os.utime(self.path("data", name), (time.time() - 60,) * 2)
        self.peer(1)
        with self.playing(1):
            words = self.peer(2)
            self.assertEqual(words[words.index("--trace") + 1], self.path("data/peer2.trace"))
            self.assertEqual(self.recorded(), {"peer22.trace"})
            self.put("data/peer2.trace", "of this session")
            words = self.peer(2)
        self.assertEqual(words[words.index("--trace") + 1], self.path("data/peer2.back1.trace"))
        self.assertEqual(self.recorded(), {"peer22.trace", "peer2.trace"})

    # Where nobody could begin, the session before was reported as if it were this one.
    def test_the_report_has_traces_of_this_session_only(self):
        self.borrow("tools/compose/image/report.sh")
        self.put("bin/padr-report", "#!/bin/sh\necho \"$@\" >&2\nexit 5\n")
        self.peer(1)
        os.remove(self.path("data/peer1.health"))
        for name, age in [("peer1.trace", -1), ("peer2.trace", -1), ("peer2.back1.trace", 60), ("peer1.json", -1), ("peer2.json", -1)]:
            self.put(f"data/{name}", "{}")
            os.utime(self.path("data", name), (time.time() - age,) * 2)
        said = self.report()
        self.assertIn(f"{self.path('data/peer1.trace')} {self.path('data/peer2.trace')} --csv", said)
        os.utime(self.path("data/peer2.trace"), (time.time() - 60,) * 2)
        self.assertEqual(self.report(), "compose-report: peer 2 has left no trace\n")

    def report(self):
        done = self.run_script("tools/compose/image/report.sh", PADR_DATA=self.path("data"), PADR_PEERS="2")
        self.assertNotEqual(done.returncode, 0)
        return done.stderr

    def recorded(self):
        return {name for name in os.listdir(self.path("data")) if name.endswith((".trace", ".json", ".pcapng")) and "peer2" in name}

    # The report waited for a minute and a half where no peer could begin.
    def test_the_report_sees_that_peers_have_come_and_gone(self):
        self.borrow("tools/compose/image/report.sh")
        self.put("bin/padr-peer", "#!/bin/sh\nexit 2\n")
        self.put("bin/sleep", '#!/bin/sh\nexec /bin/sleep "$(echo "$1" | sed "s/^[1-9]/0.1/")"\n')
        report = subprocess.Popen(["tools/compose/image/report.sh"], cwd=self.folder, stderr=subprocess.PIPE, text=True,
                                  env=self.environment(PADR_DATA=self.path("data")))  # fmt: skip
        self.run_script("tools/compose/image/peer.sh", PADR_DATA=self.path("data"), PADR_NUMBER="1")
        self.assertEqual(report.communicate(timeout=120)[1], "compose-report: peer 1 has left no trace\n")
        self.assertEqual(report.returncode, 1)

    def test_who_waits_gives_signs_of_life_and_takes_them_away(self):
        peer = subprocess.Popen(["tools/compose/image/peer.sh"], cwd=self.folder, stderr=subprocess.PIPE, text=True,
                                env=self.environment(PADR_DATA=self.path("data"), PADR_NUMBER="1", PADR_AFTER_FILE="none"))  # fmt: skip
        self.addCleanup(peer.communicate)
        sign = self.path("data/peer1.health")
        signs = set()
        deadline = time.monotonic() + PATIENCE
        while len(signs) < 2:
            self.assertLess(time.monotonic(), deadline, signs)
            if os.path.exists(sign):
                signs.add(os.stat(sign).st_mtime_ns)
            time.sleep(0.05)
        peer.terminate()
        self.assertEqual(peer.wait(timeout=PATIENCE), 143)
        self.assertFalse(os.path.exists(sign))

    # By --scale two wrote one trace, which nobody could read.
    def test_a_second_container_for_one_peer_is_refused(self):
        self.put("data/peer4.trace", "of the first")
        with open(self.path("data/.peer4.lock"), "w", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            done = self.run_script("tools/compose/image/peer.sh", PADR_DATA=self.path("data"), PADR_NUMBER="4")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, "compose-peer: another container is peer 4 already; for more peers than four see "
                         "tools/compose/crowd.yml, not --scale\n")  # fmt: skip
        self.assertEqual(set(os.listdir(self.path("data"))), {".peer4.lock", "peer4.trace"})
        self.peer(4)

    # A lookup that nobody answers takes 20 s, and was counted as one.
    def test_the_wait_for_a_name_is_as_long_as_it_says(self):
        self.borrow("tools/compose/image/firewall.sh")
        self.put("bin/getent", "#!/bin/sh\n/bin/sleep 6\nexit 2\n")
        for script in ("peer", "firewall"):
            started = time.monotonic()
            done = self.run_script(f"tools/compose/image/{script}.sh", PADR_DATA=self.path("data"), PADR_NUMBER="2",
                                   PADR_JOIN_TIMEOUT="3", PADR_FIREWALL="cut peer1")  # fmt: skip
            self.assertEqual(done.returncode, 1)
            self.assertIn(f"compose-{script}: there is no 'peer1' on this network after 3 s\n", done.stderr)
            self.assertLess(time.monotonic() - started, 15)

    # The shell computed with the seed, and its messages were about that.
    def test_the_peer_sees_every_seed_as_it_is(self):
        for seed, netem_seed in [("", "102"), ("0", "2"), ("7", "702"), ("1000000000000000007", "702"),
                                 ("18446744073709551615", "74407370955161502")]:  # fmt: skip
            words = self.peer(2, PADR_SEED=seed)
            self.assertEqual(words[words.index("--seed") + 1], seed or "1")
            self.assertEqual(words[words.index("--netem-seed") + 1], netem_seed)
        for seed in ["x", "08", "1.5", "1 2", "-1"]:
            words = self.peer(2, PADR_SEED=seed)
            self.assertEqual(words[words.index("--seed") + 1], seed)

    @unittest.skipUnless(yaml and shutil.which("docker-compose"), "no docker-compose and yaml")
    def test_compose_hands_on_what_is_set_and_nothing_else(self):
        for files, number, outside, wanted in [
            ([], 3, {}, "delay 50ms 10ms loss 2%"),
            ([], 3, {"PADR_NETEM": ""}, None),
            ([], 3, {"PADR_NETEM_3": ""}, None),
            ([], 3, {"PADR_NETEM_3": "loss 1%"}, "loss 1%"),
            ([], 3, {"PADR_NETEM_4": ""}, "delay 50ms 10ms loss 2%"),
            ([ASYMMETRIC], 3, {}, "delay 20ms 5ms loss 1% rate 128kbit"),
            ([ASYMMETRIC], 3, {"PADR_NETEM_3": ""}, None),
            ([CROWD], 7, {}, "delay 30ms 10ms loss 1%"),
            ([CROWD], 7, {"PADR_NETEM_7": ""}, None),
        ]:  # fmt: skip
            flags = [flag for file in ["docker-compose.yml", *files] for flag in ("-f", file)]
            done = subprocess.run(["docker-compose", *flags, "config"], cwd=REPOSITORY, env=self.environment(**outside),
                                  capture_output=True, text=True, check=False)  # fmt: skip
            self.assertEqual(done.returncode, 0, done.stderr)
            inside = yaml.safe_load(done.stdout)["services"][f"peer{number}"]["environment"]
            inside = {name: value for name, value in inside.items() if name.startswith("PADR_NETEM") and value is not None}
            self.assertEqual(self.netem(number, **inside), wanted, (files, outside))

    @unittest.skipUnless(yaml and shutil.which("docker-compose"), "no docker-compose and yaml")
    def test_each_variable_that_is_listed_counts(self):
        with open(os.path.join(REPOSITORY, "docker-compose.yml"), encoding="utf-8") as f:
            listed = set(re.findall("^#   (PADR_[A-Z]+)=", f.read(), re.MULTILINE))
        self.assertLessEqual({"PADR_SEED", "PADR_INPUT", "PADR_ARGS"}, listed)
        done = subprocess.run(["docker-compose", "-f", "docker-compose.yml", "config"], cwd=REPOSITORY, check=True, stdout=subprocess.PIPE,
                              text=True, env=self.environment(**{name: f"set-{name}".lower() for name in listed}))  # fmt: skip
        peer = yaml.safe_load(done.stdout)["services"]["peer2"]
        for name in listed - {"PADR_IMAGE"}:
            self.assertEqual(peer["environment"][name], f"set-{name}".lower())
        self.assertEqual(peer["image"], "set-padr_image")


if __name__ == "__main__":
    unittest.main()
