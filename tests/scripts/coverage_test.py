#!/usr/bin/env python3
"""tools/coverage.py on a small program: what it counts, and what it says where gcov fails.

Usage: coverage_test.py REPOSITORY [unittest arguments]
"""

import os
import sys
import unittest

from stand_in import Case

SOURCE = """int main(int count, char** words) {
  if (count > 5)
    return words[0][0];
  return 0;
}
"""
HEAD = "  lines     run        \n"
COUNTED = "      4       3   75.0%  {}\n"


class Coverage(Case):
    def setUp(self):
        super().setUp()
        self.borrow("tools/coverage.py")
        self.put("common/a.c", SOURCE)
        os.makedirs(self.path("build/coverage"))
        done = self.run_script("sh", "-c", "cc --coverage -c common/a.c -o build/coverage/a.o && cc --coverage "
                               "build/coverage/a.o -o build/coverage/a && build/coverage/a")  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)

    def coverage(self, *arguments):
        return self.run_script(sys.executable, "-B", "tools/coverage.py", *arguments)

    def test_counts_lines(self):
        done = self.coverage("common", "--missing")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout, HEAD + COUNTED.format("common") + COUNTED.format("common/a.c")[:-1] + "  not: 3\n")

    # Both gave 0 lines and exit code 0.
    def test_a_relative_folder_and_a_place_with_a_dot(self):
        for place in ("./common/", "common/../common", ".", self.path("common")):
            done = self.coverage("--build", "build/coverage", place)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual(done.stdout.splitlines()[1].split()[:2], ["4", "3"], place)
        self.assertEqual(self.coverage("..").returncode, 2)

    def test_wrong_arguments_are_told_of_in_a_line(self):
        done = self.coverage("--speed")
        self.assertEqual((done.returncode, done.stderr), (2, "coverage.py: unrecognized arguments: --speed (see --help)\n"))

    def test_says_why_gcov_fails(self):
        os.rename(self.path("build/coverage/a.gcno"), self.path("build/coverage/b.gcno"))
        done = self.coverage("common")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, r"^coverage\.py: gcov failed on .*/build/coverage/a\.gcda: .*cannot open notes file")


if __name__ == "__main__":
    unittest.main()
