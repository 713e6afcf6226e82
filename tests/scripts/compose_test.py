#!/usr/bin/env python3
"""What docker-compose.yml and tools/compose make of the environment, and tools/compose/image/peer.sh of that.

Usage: compose_test.py REPOSITORY [unittest arguments]
"""

import os
import shutil
import subprocess
import unittest

from stand_in import REPOSITORY, Case

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
        self.assertEqual(set(os.listdir(self.path("data"))), others)

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


if __name__ == "__main__":
    unittest.main()
