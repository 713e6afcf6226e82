#!/usr/bin/env python3
"""One version in all places: CMakeLists.txt, CHANGELOG.md, CITATION.cff, SECURITY.md, docs/upgrade.md and the numbers of formats in
the code.

Usage: release_test.py REPOSITORY
"""

import os
import re
import sys
import unittest

REPOSITORY = sys.argv.pop(1) if len(sys.argv) > 1 else os.getcwd()


def text(name):
    with open(os.path.join(REPOSITORY, name), encoding="utf-8") as file:
        return file.read()


def found(name, pattern):
    match = re.search(pattern, text(name), re.M)
    if not match:
        raise AssertionError(f"{name} has nothing like {pattern}")
    return match[1]


class Release(unittest.TestCase):
    version = found("CMakeLists.txt", r"^project\(padr VERSION (\d+\.\d+\.\d+)")

    def test_the_changelog_has_the_version_behind_what_is_not_released(self):
        heads = re.findall(r"^## (.*)$", text("CHANGELOG.md"), re.M)
        self.assertEqual(heads[0], "[Unreleased]")
        self.assertRegex(heads[1], rf"^\[{re.escape(self.version)}\] - \d{{4}}-\d\d-\d\d$")

    def test_the_citation_has_version_and_date_of_the_changelog(self):
        date = found("CHANGELOG.md", rf"^## \[{re.escape(self.version)}\] - (.*)$")
        self.assertEqual(found("CITATION.cff", r"^version: (.*)$"), self.version)
        self.assertEqual(found("CITATION.cff", r"^date-released: (.*)$"), date)

    def test_the_citation_is_one(self):
        """The keys that Citation File Format 1.2.0 asks for, and the paper as README.md has it."""
        for key in ("cff-version: 1.2.0", "message: ", "title: ", "authors:", "type: software", "license: MIT", "references:"):
            self.assertRegex(text("CITATION.cff"), rf"(?m)^{key}")
        paper = found("CITATION.cff", r'^ +title: "(A Physics.*)"$')
        readme = " ".join(text("README.md").split())
        self.assertIn(paper, readme)
        for name in re.findall(r"family-names: (\w+)", text("CITATION.cff")):
            self.assertIn(name, readme)
        for line in text("CITATION.cff").splitlines():
            self.assertNotIn("\t", line)

    def test_the_version_is_supported(self):
        self.assertRegex(text("SECURITY.md"), rf"(?m)^\| {re.escape(self.version.rsplit('.', 1)[0])} \| yes \|$")

    def test_versions_of_formats_are_those_of_the_code(self):
        row = found("docs/upgrade.md", rf"^\| {re.escape(self.version)} \| (.*) \|$").split(" | ")
        self.assertEqual(row, [
            found("common/wire/seal.h", r"kProtocolVersion = (\d+);"),
            found("common/trace/events.h", r"kFormatVersion = (\d+);"),
            found("common/monitor/format.h", r'kPreamble\{"PMON\\(\d+)"'),
            found("tools/monitor/page/PROTOCOL.md", r'"type": "hello", "protocol": (\d+)'),
        ])  # fmt: skip


if __name__ == "__main__":
    unittest.main()
