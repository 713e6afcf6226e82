#!/usr/bin/env python3
"""Makes the reference pages of the programs from what they print with --help, and those of the fields of datagrams and
scenarios from the sources, and finds those that are stale.

usage: tools/docs/reference.py [--bin DIR] [make | check]

  make    write docs/reference-*.md  (the default)
  check   name the pages that would come out differently; write nothing

  --bin DIR  where the programs are  (default: build/release/bin)

Exit status: 0; 1 if a page is stale or a program cannot be asked; 2 for wrong arguments.
"""

import os
import re
import subprocess
import sys

import datagram_fields
import help_text
import pages
import scenario_fields

PROGRAMS = {
    "padr-peer": ["keygen", "fingerprint"],  # subcommands that the help itself does not list
    "padr-lab": [],
    "padr-report": [],
    "padr-capture": [],
    "padr-monitor": [],
    "padr-netem": [],
}
SCRIPTS = ["demo.sh", "chaos.sh", "scenario.sh", "bench.sh", "package.sh", "figures.py", "pictures.sh", "doc_commands.py",
           "docs.sh", "test.sh", "fuzz.sh", "coverage.py", "format.sh", "deps.sh"]  # fmt: skip
SCRIPTS_PAGE = "docs/reference-scripts.md"
FIELDS_PAGE = "docs/reference-fields.md"
SCENARIO_PAGE = "docs/reference-scenario.md"
MADE = "<!-- Made by tools/docs/reference.py from {}; edits here are lost. -->"


class Failed(Exception):
    pass


def help_of(*command):
    try:
        done = subprocess.run([*command, "--help"], capture_output=True, timeout=60, check=False, stdin=subprocess.DEVNULL,
                              cwd=pages.ROOT)  # fmt: skip
    except OSError as error:
        raise Failed(f"{command[0]}: {error.strerror}; build the programs first, or name their folder with --bin") from error
    if done.returncode != 0:
        raise Failed(f"{' '.join(command)} --help ended with {done.returncode}: {done.stderr.decode().strip()[-400:]}")
    return done.stdout.decode()


def subcommands(text):
    found = re.search(r"^Subcommands:\n((?: {2}\S.*\n)+)", text, re.M)
    return re.findall(r"^ {2}(\S+)", found[1], re.M) if found else []


def remember(known, text, name, level):
    """Notes which groups of options stand under which heading, for those that come after."""
    for title, block in re.findall(r"^([A-Z][^:\n]*):\n((?: {2}.*\n)+)", text, re.M):
        table = help_text.rows(block.rstrip("\n").split("\n"))
        if table is not None:
            known.setdefault(str(table), (f"{title} of {name}", pages.anchor_of(title)))


def program_page(folder, program, hidden):
    path = os.path.join(folder, program)
    text = help_of(path)
    out = [MADE.format(f"{program} --help"), "", f"# {program}", "", help_text.markdown(text, 2, {})]
    known = {}
    remember(known, text, f"`{program}`", 2)
    for name in subcommands(text) + hidden:
        command = help_of(path, name).lstrip("\n")
        out += [f"## {program} {name}", "", help_text.markdown(command, 3, known)]
        remember(known, command, f"`{program} {name}`", 3)
    return "\n".join(out)


def asked(script):
    path = os.path.join("tools", script)
    return [sys.executable, "-B", path] if script.endswith(".py") else [path]


def scripts_page():
    left_out = {name for name in os.listdir(os.path.join(pages.ROOT, "tools")) if name.endswith(".sh")} - set(SCRIPTS)
    if left_out:
        raise Failed(f"not in SCRIPTS of tools/docs/reference.py: {', '.join(sorted(left_out))}")
    out = [MADE.format("the scripts' --help"), "", "# Scripts", "",
           "Each of them says with `--help` what it does.", ""]  # fmt: skip
    for script in SCRIPTS:
        out += [f"## tools/{script}", "", help_text.markdown(help_of(*asked(script)), 3, {})]
    return "\n".join(out)


def reference(folder):
    """(page, text) of every reference page."""
    for program, hidden in PROGRAMS.items():
        yield f"docs/reference-{program}.md", program_page(folder, program, hidden)
    yield SCRIPTS_PAGE, scripts_page()
    yield FIELDS_PAGE, MADE.format(f"{datagram_fields.PLUGIN} and {datagram_fields.EXPORT}") + "\n\n" + datagram_fields.page()
    yield SCENARIO_PAGE, MADE.format(scenario_fields.SCHEMA) + "\n\n" + scenario_fields.page()


def check(folder):
    stale = 0
    for page, text in reference(folder):
        if not os.path.exists(os.path.join(pages.ROOT, page)) or pages.read(page) != text:
            print(f"stale: {page}; make it anew: tools/docs/reference.py --bin {folder}")
            stale += 1
    print(f"{stale} stale")
    return 1 if stale else 0


def make(folder):
    for page, text in list(reference(folder)):
        with open(os.path.join(pages.ROOT, page), "w", encoding="utf-8") as file:
            file.write(text)
        print(page)
    return 0


def main(arguments):
    if "--help" in arguments or "-h" in arguments:
        print(__doc__.strip())
        return 0
    folder = os.path.join(pages.ROOT, "build", "release", "bin")
    if len(arguments) >= 2 and arguments[0] == "--bin":
        folder = os.path.abspath(arguments[1])
        arguments = arguments[2:]
    if arguments not in ([], ["make"], ["check"]):
        print(f"reference.py: wrong arguments: {' '.join(arguments)}; wanted: make or check; see --help", file=sys.stderr)
        return 2
    try:
        return check(folder) if arguments == ["check"] else make(folder)
    except (Failed, ValueError, subprocess.TimeoutExpired) as error:
        print(f"reference.py: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
