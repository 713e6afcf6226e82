#!/usr/bin/env python3
"""A check that cannot fail proves nothing: tables that would come out differently, or were never made, are named.

usage: can_fail_test.py FIGURES-COMMAND...
"""

import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NAME = "convergence"


def check(kept):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(kept, file)
        file.flush()
        done = subprocess.run([*sys.argv[1:], "--kept", file.name, "check", NAME], stdout=subprocess.PIPE, check=False)
    return done.returncode, done.stdout.decode()


def expect(what, holds, said):
    if not holds:
        sys.exit(f"{what}; it said:\n{said}")


with open(os.path.join(ROOT, "docs", "figures.json"), encoding="utf-8") as file:
    kept = json.load(file)
status, said = check(kept)
expect("what is fresh must pass", status == 0 and "0 stale" in said, said)
kept[NAME]["short_form"] = "another"
status, said = check(kept)
expect("what comes out differently must be named", status == 1 and f"stale: {NAME} (docs/lab.md), made at" in said, said)
del kept[NAME]
status, said = check(kept)
expect("what has never been made must be named", status == 1 and f"stale: {NAME} (docs/lab.md) has never" in said, said)
done = subprocess.run([*sys.argv[1:], "check", "no-such-table"], stderr=subprocess.PIPE, check=False)
expect("an unknown name is a wrong argument", done.returncode == 2, done.stderr.decode())
done = subprocess.run([*sys.argv[1:], "fake"], stderr=subprocess.PIPE, check=False)
said = done.stderr.decode()
expect("wrong arguments are told of in a line", done.returncode == 2 and said.startswith("figures.py: ") and said.count("\n") == 1, said)
for broken in ("{", "[]", '{"a": 1}', "\udcff"):
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", errors="surrogateescape") as file:
        file.write(broken)
        file.flush()
        done = subprocess.run([*sys.argv[1:], "--kept", file.name, "check", NAME], stderr=subprocess.PIPE, check=False)
        said = done.stderr.decode()
        begin = f"figures.py: --kept: cannot read '{file.name}': "
        expect("a broken file is a wrong argument", done.returncode == 2 and said.startswith(begin) and said.count("\n") == 1, said)
with tempfile.TemporaryDirectory() as folder:
    lab = os.path.join(folder, "padr-lab")
    with open(lab, "w", encoding="utf-8") as file:
        file.write("#!/bin/sh\necho no such thing >&2\nexit 3\n")
    os.chmod(lab, 0o755)
    done = subprocess.run([*sys.argv[1:], "--bin", folder, "check", NAME], stderr=subprocess.PIPE, check=False)
    said = done.stderr.decode()
    expect("a program that fails must be told of", done.returncode == 1 and "ended with 3: no such thing" in said, said)
