"""What the checks of the assignments share: finding the programs, reading files, and saying what is missing."""

import argparse
import csv
import os
import shutil
import subprocess
import sys


class NotYet(Exception):
    """Something that the assignment asks for and that is not there; the message says what."""


def program(name):
    """Where a program is: in the folder that PADR_BIN names, or in the PATH."""
    found = os.environ.get("PADR_BIN") and os.path.join(os.environ["PADR_BIN"], name)
    for path in (found, shutil.which(name)):
        if path and os.access(path, os.X_OK):
            return path
    print(f"there is no {name} in the PATH: add the folder of the programs, such as build/release/bin", file=sys.stderr)
    raise SystemExit(2)


def run(*words):
    """Runs a program of the project; its result."""
    return subprocess.run([program(words[0]), *words[1:]], capture_output=True, text=True, timeout=300, check=False)


def need(folder, name):
    """The path of a file that must be handed in."""
    path = os.path.join(folder, name)
    if not os.path.isfile(path):
        raise NotYet(f"{name} is missing in {folder}")
    return path


def rows(path):
    """The rows of a CSV with a header."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def check(description, judge):
    """Runs `judge(folder)`, which returns the sentence of praise or raises NotYet, and ends the program.

    Exit status: 0 pass, 1 not yet, 2 for wrong arguments.
    """
    parser = argparse.ArgumentParser(description=description, epilog="Prints 'pass' or what is missing. Exit: 0 pass, 1 not yet, 2 usage.")
    parser.add_argument("folder", help="what is handed in")
    folder = parser.parse_args().folder
    if not os.path.isdir(folder):
        print(f"'{folder}' is no folder", file=sys.stderr)
        raise SystemExit(2)
    try:
        print(f"pass: {judge(folder)}")
    except NotYet as e:
        print(f"not yet: {e}")
        raise SystemExit(1) from None
