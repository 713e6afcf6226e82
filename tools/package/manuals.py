#!/usr/bin/env python3
"""Writes manual pages by help2man from what the programs say with --help, one for each program and for each of its commands.

usage: manuals.py FOLDER VERSION PROGRAM...

Writes FOLDER/NAME.1.gz and FOLDER/NAME-COMMAND.1.gz. Their date is
SOURCE_DATE_EPOCH of the environment, or else today's.
"""

import gzip
import os
import re
import subprocess
import sys
import tempfile

import help_text


def summary(name, text):
    """The first sentence of a --help text, up to what explains it."""
    first = re.sub(rf"^{name}: ", "", " ".join(text.split("\n\n")[0].split("Usage:")[0].split()))
    first = re.split(r"[:.;](?: |$)", first)[0]
    return first[0].lower() + first[1:] if first[1:2].islower() else first


def laid_out(text):
    """The --help text as help2man understands it: what an option takes in a line of its own, and programs without their folder."""
    lines = []
    for line in text.splitlines():
        option = help_text.OPTION.match(line)
        if option:
            takes, says = option[3] or "", option[4] or ""
            values = re.match(r"^(.*\]|\S*=\S+|TEXT:\S+)(?: ([A-Z].*))?$", takes)  # CLI11 leaves one space there at times
            if values and values[2] and not says:
                takes, says = values[1], values[2]
            short = f"{option[1]}, " if option[1] else ""
            lines.append(f"  {short}{option[2]} {takes}".rstrip())
            lines += [" " * 30 + says] if says else []
        else:
            lines.append(re.sub(r"^([Uu]sage: )\S*/", r"\1", line))
    return "\n".join(lines) + "\n"


def page(version, title, text, one_line):
    """The page as troff. help2man calls a program: a script that says the text stands in for it."""
    with tempfile.TemporaryDirectory() as folder:
        stand_in, saying = os.path.join(folder, title), os.path.join(folder, "text")
        with open(saying, "w", encoding="utf-8") as file:
            file.write(laid_out(text))
        with open(stand_in, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\nexec cat '{saying}'\n")
        os.chmod(stand_in, 0o755)
        options = ["--no-info", "--section=1", f"--name={one_line}", f"--version-string={version}", "--manual=PADR"]
        made = subprocess.run(["help2man", *options, f"--source=padr {version}", stand_in], capture_output=True, text=True,
                              check=False, env={**os.environ, "LC_ALL": "C.UTF-8"})  # fmt: skip
    if made.returncode != 0:
        sys.exit(f"manuals.py: help2man on {title}: {made.stderr.strip()}")
    return made.stdout


def main(folder, version, *programs):
    os.makedirs(folder, exist_ok=True)
    for program in programs:
        name = os.path.basename(program)
        commands = help_text.commands_of(program)
        for command, text in commands.items():
            one_line = commands[""].commands[command] if command else summary(name, text.text)
            title = f"{name}-{command}" if command else name
            troff = page(version, title, text.text, one_line)
            with open(os.path.join(folder, title + ".1.gz"), "wb") as file:
                file.write(gzip.compress(troff.encode(), 9, mtime=0))


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(
            __doc__.strip() if sys.argv[1:] in (["--help"], ["-h"]) else "manuals.py: give a folder, a version and programs (see --help)")
    main(*sys.argv[1:])
