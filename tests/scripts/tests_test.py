#!/usr/bin/env python3
"""tools/test.sh with a build that is a list of small tests: what it says of those that were skipped.

Usage: tests_test.py REPOSITORY [unittest arguments]
"""

import unittest

from stand_in import Case

CMAKE = """#!/bin/sh
[ "$1" = --preset ] && mkdir -p build/release && cp list build/release/CTestTestfile.cmake
exit 0
"""
GOOD = 'add_test(good "true")\n'
BAD = 'add_test(bad "false")\n'
SCRIPT = """add_test(lacking "sh" "-c" "echo one; echo 'skipped: tshark not found'; echo two; exit 77")
set_tests_properties(lacking PROPERTIES SKIP_RETURN_CODE 77)
"""
GTEST = """add_test(Suite.Case "sh" "-c" "echo 'a.cpp:1: Skipped'; echo 'no gnuplot'; echo '[  SKIPPED ] Suite.Case'")
set_tests_properties(Suite.Case PROPERTIES SKIP_REGULAR_EXPRESSION "\\\\[  SKIPPED \\\\]")
"""


class Tests(Case):
    def setUp(self):
        super().setUp()
        self.borrow("tools/test.sh")
        self.put("tools/deps.sh", "#!/bin/sh\n")
        self.put("bin/cmake", CMAKE)

    def said(self, text, *arguments):
        self.put("list", text)
        done = self.run_script("tools/test.sh", *arguments)
        return done.returncode, [line for line in done.stdout.splitlines() if line.startswith("skipped: ")]

    def test_who_was_skipped_and_why_is_said_at_the_end(self):
        code, skipped = self.said(GOOD + SCRIPT + GTEST)
        self.assertEqual(code, 0)
        self.assertCountEqual(skipped, ["skipped: lacking: tshark not found", "skipped: Suite.Case: no gnuplot"])

    def test_also_if_others_fail(self):
        code, skipped = self.said(BAD + SCRIPT)
        self.assertNotEqual(code, 0)
        self.assertEqual(skipped, ["skipped: lacking: tshark not found"])

    def test_nothing_is_said_where_nothing_was_skipped(self):
        self.assertEqual(self.said(GOOD + SCRIPT, "-R", "good"), (0, []))


if __name__ == "__main__":
    unittest.main()
