#!/usr/bin/env python3
"""tools/link_traces.py makes the link traces that are built in.

Usage: link_traces_test.py REPOSITORY [unittest arguments]
"""

import os
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = sys.argv.pop(1)
FOLDER = os.path.join(REPOSITORY, "shell/link_traces")


class LinkTraces(unittest.TestCase):
    def test_makes_what_is_built_in(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", os.path.join(REPOSITORY, "tools/link_traces.py"), folder], check=True)
            self.assertEqual(sorted(os.listdir(folder)), sorted(n for n in os.listdir(FOLDER) if n.endswith(".link")))
            for name in os.listdir(folder):
                with open(os.path.join(folder, name), "rb") as new, open(os.path.join(FOLDER, name), "rb") as old:
                    made = new.read()
                    self.assertEqual(made, old.read(), f"tools/link_traces.py makes {name} anew")
                self.assertLess(len(made), 65536)

    def test_says_what_it_does_and_what_it_wants(self):
        def said(*arguments):
            return subprocess.run([sys.executable, "-B", os.path.join(REPOSITORY, "tools/link_traces.py"), *arguments],
                                  capture_output=True, text=True, check=False)  # fmt: skip

        self.assertIn("Usage: tools/link_traces.py [FOLDER]", said("--help").stdout)
        for arguments in (["/no such folder"], ["/", "--fast"]):
            done = said(*arguments)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr, f"link_traces.py: '{arguments[-1]}' is not allowed; give one folder that exists (see --help)\n")


if __name__ == "__main__":
    unittest.main()
