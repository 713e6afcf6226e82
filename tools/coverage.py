#!/usr/bin/env python3
"""Which lines the tests have run, by folder or file, after a build with the preset `coverage` has run some.

usage: tools/coverage.py [--build DIR] [--missing] [PLACE...]

  PLACE        folder or file of the repository, such as common/wire or common/sync/validation.cpp  (default: common peer)
  --build DIR  where it was built                                                              (default: build/coverage)
  --missing    also the lines that none has run

For example, what the fast suites reach of the wire:

  cmake --preset coverage -DPADR_TEST_SUITES="wire;channel;session;replica;fuzz" && cmake --build --preset coverage
  ctest --preset coverage && tools/coverage.py --missing common/wire

A line counts once, whatever number of programs it is in. Needs gcov of the compiler that built.
Exit status: 0; 1 if nothing has been run or gcov fails; 2 for wrong arguments.
"""

import argparse
import concurrent.futures
import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class Failed(Exception):
    pass


def notes(build):
    return [os.path.join(folder, name) for folder, _, names in os.walk(build) for name in names if name.endswith(".gcda")]


def lines_of(data):
    """What one object file's run says: (file, line, how often) of every line of the repository."""
    try:
        done = subprocess.run(["gcov", "--json-format", "--stdout", data], capture_output=True, text=True, check=False,
                              cwd=os.path.dirname(data))  # fmt: skip
    except FileNotFoundError:
        raise Failed("there is no gcov here; it comes with the compiler") from None
    if done.returncode != 0:
        raise Failed(f"gcov failed on {data}: {done.stderr.strip()}")
    found = []
    for text in done.stdout.splitlines():
        report = json.loads(text)
        for file in report["files"]:
            path = os.path.relpath(os.path.normpath(os.path.join(report["current_working_directory"], file["file"])), ROOT)
            if path.startswith("..") or path.startswith("build"):
                continue
            found += [(path, line["line_number"], line["count"]) for line in file["lines"]]
    return found


def ranges(numbers):
    """1, 2, 3, 7 as 1-3, 7."""
    spans = []
    for n in sorted(numbers):
        if spans and n == spans[-1][1] + 1:
            spans[-1][1] = n
        else:
            spans.append([n, n])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in spans)


def main():
    parser = argparse.ArgumentParser(add_help=False)
    parser.error = lambda message: parser.exit(2, f"{parser.prog}: {message} (see --help)\n")
    parser.add_argument("--help", "-h", action="store_true")
    parser.add_argument("--build", default=os.path.join(ROOT, "build", "coverage"))
    parser.add_argument("--missing", action="store_true")
    parser.add_argument("places", nargs="*", default=["common", "shell", "peer"])
    a = parser.parse_args()
    if a.help:
        print(__doc__)
        return 0
    build = os.path.abspath(a.build)
    places = [os.path.relpath(os.path.join(ROOT, place), ROOT) for place in a.places]
    for place in places:
        if place.startswith("..") or not os.path.exists(os.path.join(ROOT, place)):
            print(f"coverage.py: there is no {place} in the repository (see --help)", file=sys.stderr)
            return 2
    data = notes(build)
    if not data:
        print(f"coverage.py: nothing built with the preset `coverage` has been run in {a.build}", file=sys.stderr)
        return 1
    runs = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        try:
            for found in pool.map(lines_of, data):
                for path, line, count in found:
                    of = runs.setdefault(path, {})
                    of[line] = of.get(line, 0) + count
        except Failed as e:
            pool.shutdown(cancel_futures=True)
            print(f"coverage.py: {e}", file=sys.stderr)
            return 1
    print(f"{'lines':>7} {'run':>7} {'':>7}")
    for place in places:
        files = sorted(f for f in runs if place in (".", f) or f.startswith(place + "/"))
        for name, of in [(place, files)] + [(f, [f]) for f in files if f != place]:
            every = sum(len(runs[f]) for f in of)
            run = sum(1 for f in of for count in runs[f].values() if count)
            missing = [n for f in of if f == name for n, count in runs[f].items() if not count]
            told = f"  not: {ranges(missing)}" if a.missing and missing else ""
            print(f"{every:7} {run:7} {100 * run / every if every else 0:6.1f}%  {name}{told}")
    return 0


sys.exit(main())
