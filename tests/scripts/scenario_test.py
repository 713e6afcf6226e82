#!/usr/bin/env python3
"""tools/scenario.sh with an engine that only says yes: into which folder it puts what was recorded, and which it empties.

Usage: scenario_test.py REPOSITORY [unittest arguments]
"""

import os
import unittest

from stand_in import Case

DOCKER = """#!/bin/sh
case "$*" in
  *"cp :/data"*) mkdir "$3/report" && echo '  "lives": 0' >"$3/report/report.json" ;;
  *ExitCode*) echo 0 ;;
esac
"""


class Scenario(Case):
    def setUp(self):
        super().setUp()
        self.borrow("repository/tools/scenario.sh", "tools/scenario.sh")
        self.put("repository/tools/compose/lan.yml", "# A sample.\n")
        self.put("bin/docker", DOCKER)

    def scenario(self, *arguments):
        return self.run_script("repository/tools/scenario.sh", "lan", "--no-build", *arguments)

    def test_a_relative_folder_is_the_callers(self):
        self.put("repository/here/there", "of the repository")
        done = self.scenario("--out", "here")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(os.path.exists(self.path("here/report/report.json")))
        self.assertEqual(self.text("repository/here/there"), "of the repository")

    def test_the_default_is_the_repositorys(self):
        self.assertEqual(self.scenario().returncode, 0)
        self.assertTrue(os.path.exists(self.path("repository/out/scenario/lan/report/report.json")))

    def test_a_folder_of_an_earlier_run_is_emptied(self):
        self.assertEqual(self.scenario("--out", "here").returncode, 0)
        self.put("here/peer1.trace", "older")
        self.assertEqual(self.scenario("--out", "here").returncode, 0)
        self.assertFalse(os.path.exists(self.path("here/peer1.trace")))

    def test_no_other_folder_is_emptied(self):
        self.put("here/letter", "mine")
        done = self.scenario("--out", "here")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"scenario.sh: --out '{os.path.realpath(self.path('here'))}' has files that no scenario put "
                         "there; name another folder (see --help)\n")  # fmt: skip
        self.assertEqual(self.text("here/letter"), "mine")
        self.assertEqual(self.scenario("--out", ".").returncode, 2)
        self.assertEqual(self.scenario("--out=").stderr, "scenario.sh: --out must not be empty (see --help)\n")

    def test_an_empty_folder_is_taken(self):
        os.mkdir(self.path("here"))
        self.assertEqual(self.scenario("--out", "here").returncode, 0)

    # It took the containers of the other away.
    def test_what_is_being_played_is_left_alone(self):
        self.put("bin/docker", f"""#!/bin/sh
echo "$*" >>{self.path("calls")}
case "$*" in
  ps*) echo 0123456789ab ;;
  *State.Running*) echo true ;;
esac
""")
        done = self.scenario("--out", "here")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, "scenario.sh: 'lan' is being played already; wait for it, or end it by: "
                         "docker compose --project-name padr-lan down --volumes --remove-orphans\n")  # fmt: skip
        self.assertNotIn("down", self.text("calls"))
        self.assertFalse(os.path.exists(self.path("here")))


if __name__ == "__main__":
    unittest.main()
