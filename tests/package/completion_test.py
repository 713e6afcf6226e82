#!/usr/bin/env python3
"""Completion for bash: every option that --help has is offered, and the values offered are those that the program allows.

Usage: completion_test.py REPOSITORY PROGRAM...
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY, PROGRAMS = sys.argv[1], sys.argv[2:]
del sys.argv[1:]

COMPLETE = """source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
compopt() { :; }
"_${1//-/_}"
if ((${#COMPREPLY[@]})); then printf '%s\\n' "${COMPREPLY[@]}"; fi
"""


def run(*command, cwd=None):
    return subprocess.run(command, cwd=cwd, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=20)


class Completion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.here = os.path.join(cls.folder.name, "here")  # where file names are completed
        os.mkdir(cls.here)
        cls.programs = {os.path.basename(path): path for path in PROGRAMS}
        cls.programs["padr-demo"] = os.path.join(cls.folder.name, "bin", "padr-demo")
        os.mkdir(os.path.dirname(cls.programs["padr-demo"]))
        shutil.copy(os.path.join(REPOSITORY, "tools", "demo.sh"), cls.programs["padr-demo"])
        script = os.path.join(REPOSITORY, "tools", "package", "completion.py")
        subprocess.run([sys.executable, "-B", script, cls.folder.name, *cls.programs.values()], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def complete(self, *words):
        done = run("bash", "-c", COMPLETE, "bash", os.path.join(self.folder.name, words[0]), *words, cwd=self.here)
        self.assertEqual((done.returncode, done.stderr), (0, ""), words)
        return done.stdout.split()

    def options_in_help(self, *command):
        text = run(self.programs[command[0]], *command[1:], "--help").stdout
        found = re.findall(r"^ {2}(?:-\w, ?)?(--[\w-]+)", text, re.M)
        self.assertIn("--help", found)
        return found

    def commands(self):
        """Every program and every command of one, as words."""
        for name, path in self.programs.items():
            yield (name,)
            listed = re.search(r"^Subcommands:\n((?: {2}\w.*\n)+)", run(path, "--help").stdout, re.M)
            if listed:
                commands = re.findall(r"^ {2}(\w+)", listed[1], re.M)
                self.assertEqual(sorted(self.complete(name, "")), sorted(commands))
                yield from ((name, command) for command in commands)

    def test_every_option_of_every_help_is_offered(self):
        seen = 0
        for command in self.commands():
            wanted = self.options_in_help(*command)
            seen += len(wanted)
            self.assertEqual(sorted(self.complete(*command, "--")), sorted(wanted), command)
            first = wanted[0]
            self.assertIn(first, self.complete(*command, "something", first[:5]))
        self.assertGreater(seen, 200)

    def test_values_are_those_that_the_programs_allow(self):
        """A program that refuses a value names those that it takes."""
        checked = 0
        for command in self.commands():
            if command[0] not in ("padr-peer", "padr-lab"):  # others judge a value when they have read their files
                continue
            for option in self.options_in_help(*command):
                offered = self.complete(*command, option, "")
                if not offered or option in ("--help", "--version"):
                    continue
                more = {"examples": ["--out", os.path.join(self.folder.name, "out")]}.get(command[-1], [])
                refused = run(self.programs[command[0]], *command[1:], option, "no-such-value", *more)
                self.assertEqual(refused.returncode, 2, (command, option, offered, refused))
                if "required" in refused.stderr or "Requires" in refused.stderr:
                    continue
                for value in offered:
                    self.assertRegex(refused.stderr, rf"(?<![\w-]){value}(?![\w-])", (command, option))
                listed = re.search(r"(?:give one of|give some of|neither a file nor one of|not in) \{?([\w, -]*)", refused.stderr)
                if listed and option != "--techniques":
                    self.assertEqual(offered, re.split(r", ?", listed[1]), (command, option))
                checked += 1
        self.assertGreater(checked, 60)

    def test_options_with_names_are_completed(self):
        for words, wanted in [
            (["padr-peer", "--model", ""], "static first second input auto"),
            (["padr-peer", "--model", "s"], "static second"),
            (["padr-peer", "--model", "=", "s"], "static second"),
            (["padr-peer", "--seal", "="], "auth encrypt"),
            (["padr-peer", "--log-level", ""], "trace debug info warning error off"),
            (["padr-lab", "run", "--technique", "a"], "avatar-only adaptive"),
            (["padr-lab", "run", "--fidelity", ""], "on off"),
            (["padr-lab", "chaos", "--scenario", "p"], "proxy pitch"),
            (["padr-demo", "--scene", ""], "stop-short predictor proxy"),
            (["padr-demo", "--technique", "f"], "fixed full"),
            (["padr-demo", "--page", ""], "off"),
            (["padr-peer", "--seed", ""], ""),
        ]:
            self.assertEqual(sorted(set(self.complete(*words))), sorted(wanted.split()), words)

    def test_files_are_completed_where_a_file_is_wanted(self):
        folder, trace = os.path.join(self.here, "traces"), os.path.join(self.here, "peer0.trace")
        os.mkdir(folder)
        self.addCleanup(os.rmdir, folder)
        with open(trace, "w", encoding="utf-8"):
            pass
        self.addCleanup(os.remove, trace)
        self.assertEqual(self.complete("padr-report", "pe"), ["peer0.trace"])
        self.assertEqual(sorted(self.complete("padr-peer", "--trace", "")), ["peer0.trace", "traces"])
        self.assertEqual(self.complete("padr-lab", "run", "--trace", ""), ["traces"])
        self.assertEqual(self.complete("padr-peer", "--scenario", "pe"), ["peer0.trace"])
        self.assertEqual(self.complete("padr-capture", "summary", "pe"), ["peer0.trace"])


if __name__ == "__main__":
    unittest.main()
