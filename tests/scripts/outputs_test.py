#!/usr/bin/env python3
"""tools/fuzz.sh and tools/bench.sh with nothing to build: where they write, and which places they refuse.

Usage: outputs_test.py REPOSITORY [unittest arguments]
"""

import os
import unittest

from stand_in import Case

BENCH = """#!/bin/sh
for word; do case $word in
  --benchmark_list_tests) echo BM_Sample ;;
  --benchmark_out=*) echo '{"benchmarks": []}' >"${word#*=}" ;;
esac; done
"""


class Outputs(Case):
    def setUp(self):
        super().setUp()
        for script in ("fuzz", "bench"):
            self.borrow(f"repository/tools/{script}.sh", f"tools/{script}.sh")
        for program in ("bin/cmake", "bin/clang++", "repository/tools/deps.sh", "repository/build/fuzz/bin/fuzz_sample"):
            self.put(program, "#!/bin/sh\n")
        self.put("repository/tests/fuzz/CMakeLists.txt", "padr_fuzz(sample sample.cpp)\n")
        self.put("repository/build/release/bin/padr-bench", BENCH)

    def fine(self, script, *arguments):
        done = self.run_script(f"repository/tools/{script}.sh", *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def refused(self, script, argument, because):
        for arguments in ([argument], argument.split("=")):
            done = self.run_script(f"repository/tools/{script}.sh", *arguments)
            self.assertEqual((done.returncode, done.stderr), (2, f"{script}.sh: {because} (see --help)\n"))

    def test_a_relative_place_is_the_callers(self):
        self.fine("fuzz", "--out", "here")
        self.assertTrue(os.path.isdir(self.path("here/corpus/sample")))
        self.fine("bench", "--json", "here/bench.json")
        self.assertTrue(os.path.exists(self.path("here/bench.json")))
        self.assertFalse(os.path.exists(self.path("repository/here")))

    def test_the_default_is_the_repositorys(self):
        self.fine("fuzz", "--minutes", "1")
        self.assertTrue(os.path.isdir(self.path("repository/out/fuzz/corpus/sample")))
        self.fine("bench")
        self.assertTrue(os.path.exists(self.path("repository/out/bench/bench.json")))

    def test_what_is_no_place_is_refused(self):
        self.put("letter", "mine")
        self.refused("fuzz", "--out=", "--out must not be empty")
        self.refused("fuzz", "--out=letter", "--out 'letter' is no directory")
        self.refused("bench", "--json=", "--json must not be empty")
        self.refused("bench", "--json=bin", "--json 'bin' is a directory; name a file")


if __name__ == "__main__":
    unittest.main()
