#!/usr/bin/env python3
"""tools/drawings.py draws the pictures that docs has, and they can be read in the dark.

Usage: drawings_test.py REPOSITORY [unittest arguments]
"""

import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

REPOSITORY = sys.argv.pop(1)


class Drawings(unittest.TestCase):
    def test_draws_what_the_documents_have(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", os.path.join(REPOSITORY, "tools/drawings.py"), folder], check=True)
            self.assertEqual(len(os.listdir(folder)), 3)
            for name in os.listdir(folder):
                with open(os.path.join(folder, name), encoding="utf-8") as new:
                    drawn = new.read()
                with open(os.path.join(REPOSITORY, "docs", name), encoding="utf-8") as old:
                    self.assertEqual(drawn, old.read(), f"tools/drawings.py draws docs/{name} anew")
                xml.etree.ElementTree.fromstring(drawn)
                self.assertIn("prefers-color-scheme: dark", drawn)

    def test_says_what_it_does_and_what_it_wants(self):
        def said(*arguments):
            return subprocess.run([sys.executable, "-B", os.path.join(REPOSITORY, "tools/drawings.py"), *arguments],
                                  capture_output=True, text=True, check=False)  # fmt: skip

        self.assertIn("Usage: tools/drawings.py [FOLDER]", said("--help").stdout)
        for arguments in (["/no such folder"], ["/", "--fast"]):
            done = said(*arguments)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr, f"drawings.py: '{arguments[-1]}' is not allowed; give one folder that exists (see --help)\n")


if __name__ == "__main__":
    unittest.main()
