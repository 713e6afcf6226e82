#!/usr/bin/env python3
"""Makes the tables and pictures with figures in the documents, and finds those that are stale.

usage: tools/figures.py [--bin DIR] [--kept FILE] list | make [NAME...] | check [NAME...]

  list    every table and picture: its name and the file that it stands in
  make    measures anew (all of them: about half an hour on two cores) and writes them, with the revision that made them
  check   repeats a short form of each measurement and compares it with the one kept in docs/figures.json: who changes
          what the lab measures learns here which tables are stale; takes about a minute

  --bin DIR    where padr-lab is                        (default: build/release/bin)
  --kept FILE  what was made when, with its short form  (default: docs/figures.json)

A table stands in its document between <!-- figures NAME --> and <!-- end NAME -->. The lab is deterministic to the bit: a short form
that comes out otherwise than before means that something has changed. One that comes out as before does not mean that
nothing has: a change may show only in long runs, or with a seed that the short form does not play.
Exit status: 0; 1 if something is stale or a measurement failed; 2 for wrong arguments.
"""

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tools", "figures"))

from documents import FIGURES  # noqa: E402  (beside this file)
from measuring import Failed, Measuring  # noqa: E402



def revision(programs):
    """Of the program that measures."""
    done = subprocess.run([os.path.join(programs, "padr-lab"), "--version"], stdout=subprocess.PIPE, check=True)
    return re.search(r"revision ([^)]+)", done.stdout.decode()).group(1)


def read_kept(path):
    """By name, what is kept of each figure. OSError or ValueError if it cannot be read."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        kept = json.load(file)
    if not isinstance(kept, dict) or not all(isinstance(v, dict) and {"short_form", "revision"} <= v.keys() for v in kept.values()):
        raise ValueError("not what `make` writes")
    return kept


def keep(all_of_them, path):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(all_of_them, file, indent=2, sort_keys=True)
        file.write("\n")


def short_form(figure, programs):
    """What the figure looks like when measured briefly."""
    with Measuring(programs, quick=True) as measuring:
        return hashlib.sha256(figure.made(measuring).encode()).hexdigest()


def write(figure, text, commands, made_at):
    path = os.path.join(ROOT, figure.file)
    with open(path, encoding="utf-8") as file:
        document = file.read()
    begin, end = f"<!-- figures {figure.name} -->", f"<!-- end {figure.name} -->"
    if document.count(begin) != 1 or document.count(end) != 1:
        raise Failed(f"{figure.file} must have '{begin}' and '{end}' once each")
    made = "\n".join(f"    {c}" for c in commands)
    text = text.strip("\n")  # spaces at the beginning make a block of the first line, too
    text = f"{begin}\n{text}\n\nMeasured at revision {made_at} by\n\n{made}\n{end}"
    document = re.sub(re.escape(begin) + ".*?" + re.escape(end), lambda _: text, document, flags=re.S)
    with open(path, "w", encoding="utf-8") as file:
        file.write(document)


def make(figures, programs, kept):
    made_at = revision(programs)
    everything = read_kept(kept)
    with Measuring(programs, quick=False) as measuring:
        for figure in figures:
            print(f"{figure.name}: measuring", flush=True)
            measuring.begin()
            text = figure.made(measuring)
            if figure.is_table:
                write(figure, text, measuring.commands, made_at)
            figure.draw(measuring, os.path.join(ROOT, "docs"))
            everything[figure.name] = {
                "file": figure.file,
                "revision": made_at,
                "commands": measuring.commands,
                "short_form": short_form(figure, programs),
            }
            keep(everything, kept)
    return 0


def check(figures, programs, kept):
    known = read_kept(kept)
    stale = []
    for figure in figures:
        was = known.get(figure.name)
        if was is None:
            stale.append(f"{figure.name} ({figure.file}) has never been made")
        elif was["short_form"] != short_form(figure, programs):
            stale.append(f"{figure.name} ({figure.file}), made at revision {was['revision']}, would come out differently now")
    for line in stale:
        print(f"stale: {line}; run: tools/figures.py make {line.split(' ', 1)[0]}")
    print(f"{len(figures)} tables and pictures checked, {len(stale)} stale")
    return 1 if stale else 0


def main():
    parser = argparse.ArgumentParser(add_help=False)
    parser.error = lambda message: parser.exit(2, f"{parser.prog}: {message} (see --help)\n")
    parser.add_argument("--help", "-h", action="store_true")
    parser.add_argument("--bin", default=os.path.join(ROOT, "build", "release", "bin"))
    parser.add_argument("--kept", default=os.path.join(ROOT, "docs", "figures.json"))
    parser.add_argument("what", nargs="?", choices=["list", "make", "check"])
    parser.add_argument("names", nargs="*")
    args = parser.parse_args()
    if args.help:
        print(__doc__.strip())
        return 0
    if args.what is None:
        parser.error("give list, make or check")
    known = {f.name: f for f in FIGURES}
    unknown = [n for n in args.names if n not in known]
    if unknown:
        print(f"figures.py: '{unknown[0]}' is none of {', '.join(known)}", file=sys.stderr)
        return 2
    figures = [known[n] for n in args.names] or FIGURES
    if args.what == "list":
        for figure in figures:
            print(f"{figure.name:<20} {figure.file}")
        return 0
    if not os.access(os.path.join(args.bin, "padr-lab"), os.X_OK):
        print(f"figures.py: there is no padr-lab in {args.bin}; build it, or name its folder with --bin", file=sys.stderr)
        return 2
    try:
        read_kept(args.kept)
    except (OSError, ValueError) as e:
        print(f"figures.py: --kept: cannot read '{args.kept}': {e} (see --help)", file=sys.stderr)
        return 2
    try:
        return (make if args.what == "make" else check)(figures, os.path.abspath(args.bin), args.kept)
    except Failed as e:
        print(f"figures.py: {e}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
