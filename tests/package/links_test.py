#!/usr/bin/env python3
"""Links of the installed documents: each leads to something that is installed, too.

Usage: links_test.py REPOSITORY BUILD_FOLDER CMAKE
"""

import os
import subprocess
import sys
import tempfile
import unittest

REPOSITORY, BUILD, CMAKE = sys.argv[1:4]
del sys.argv[1:4]
sys.path.insert(0, os.path.join(REPOSITORY, "tools", "docs"))
import pages  # noqa: E402


def dead_links(root):
    for folder, _, names in os.walk(root):
        for name in names:
            page = os.path.relpath(os.path.join(folder, name), root)
            if not name.endswith(".md"):
                continue
            for line, link in pages.links(pages.read(page, root)):
                target = "" if pages.is_outside(link) else pages.target_of(page, link)[0]
                if target.startswith("..") or not os.path.exists(os.path.join(root, target)):
                    yield f"{page}:{line}: {link}"


class Links(unittest.TestCase):
    def test_all_lead_to_what_is_installed(self):
        with tempfile.TemporaryDirectory() as prefix:
            subprocess.run([CMAKE, "--install", BUILD, "--component", "documents", "--prefix", prefix], check=True,
                           stdout=subprocess.DEVNULL)  # fmt: skip
            root = os.path.join(prefix, "share", "doc", "padr")
            self.assertTrue(os.path.isfile(os.path.join(root, "docs", "own-game.md")))
            self.assertEqual(list(dead_links(root)), [])
            os.remove(os.path.join(root, "LICENSE"))
            self.assertIn("README.md", "".join(dead_links(root)), "this can fail")


if __name__ == "__main__":
    unittest.main()
