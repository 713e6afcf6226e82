#!/usr/bin/env python3
"""Runs the commands that documents show, and compares what they print with what the documents say that they print.

usage: tools/doc_commands.py [--bin DIR] run PAGE...
       tools/doc_commands.py [--bin DIR] write PAGE...
       tools/doc_commands.py [--bin DIR] check [PAGE...]

  run     every command of docs/start.md or a tutorial, in order, in a fresh folder and a network of its own; exit 1 with the first
          thing that is not as the page says
  write   the same, and puts in what came for each shown line that has the same words and other numbers
  check   of all documents: whether each program, subcommand and option in a command is one that --help names; of tutorials:
          at most 700 words, and no figure in the text that is in no shown output

  --bin DIR      where the programs are (default: build/release/bin)
  --patience S   until what should end or come counts as missing (default: 240)
  --verbose      print the commands as they are run

How a block is run stands in a comment before it, which readers do not see: tools/doc_commands/pages.py has the words.
Exit status: 0; 1 if a document is wrong; 2 for wrong arguments.
"""

import argparse
import fcntl
import glob
import os
import re
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tools", "doc_commands"))

import options  # noqa: E402  (beside this file)
import shape  # noqa: E402
import terminals as shells  # noqa: E402
from pages import Wrong, blocks_and_stops, shortened, steps_of  # noqa: E402

MOST_WORDS = 700  # of a tutorial, shown output and comments not counted


def alone_in_the_network(arguments):
    """Starts this program anew in a network of its own, where all ports are free; or else no two of it run at once."""
    if os.environ.get("PADR_DOCUMENTS_ALONE"):
        return None
    for prefix in (["unshare", "--net"], ["unshare", "--user", "--map-root-user", "--net"]):
        ready = [*prefix, "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
        try:
            if subprocess.run([*ready, "true"], capture_output=True, check=False).returncode == 0:
                environment = {**os.environ, "PADR_DOCUMENTS_ALONE": "1"}
                os.execvpe(ready[0], [*ready, sys.executable, "-B", os.path.abspath(__file__), *arguments], environment)
        except FileNotFoundError:
            break
    lock = open(os.path.join(tempfile.gettempdir(), f"padr-documents-{os.getuid()}.lock"), "w", encoding="utf-8")
    fcntl.flock(lock, fcntl.LOCK_EX)
    return lock


def fresh_folder(folder, programs):
    """Looks like the root of the repository to a reader, with nothing made yet but the programs."""
    for name in os.listdir(ROOT):
        if name not in (".git", "build", "out", ".ci"):
            os.symlink(os.path.join(ROOT, name), os.path.join(folder, name))
    os.makedirs(os.path.join(folder, "build", "release"))
    os.symlink(programs, os.path.join(folder, "build", "release", "bin"))


def wait_until_shown(step, terminals, tolerance):
    """A terminal may still print what the page shows."""
    terminal = terminals.named(step.terminal)
    deadline = time.monotonic() + shells.patience
    while True:
        last = time.monotonic() > deadline or not terminal.running
        if terminal.running and not terminal.running.how.until_stopped and terminal.ended_by_now():
            terminal.wait()
        came = terminal.output()
        try:
            shape.compare(step.lines, came.split("\n"), tolerance)
            return came
        except Wrong:
            if last:
                raise
        time.sleep(0.05)


def run_steps(steps, folder, programs, say):
    """Runs them; of each shown output the step and what came."""
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "LC_ALL": "C.UTF-8"}
    environment.pop("PADR_KEY", None)
    came = []
    with shells.Terminals(folder, environment) as terminals:
        printed = ""
        for step in steps:
            if step.kind == "run":
                doing = [command for command in step.commands if not command.how.not_run]
                for command in doing:
                    command.text = shortened(command.text, command.how.shorter)
                    say(f"line {command.line}: {command.text}" + (f" (in {command.how.terminal})" if command.how.terminal else ""))
                if doing:
                    printed = terminals.run(doing)
            elif step.kind == "stop":
                terminals.named(step.terminal).stop()
            else:
                tolerance = shape.tolerance_of(step.tolerance, step.line)
                try:
                    if step.terminal:
                        text = wait_until_shown(step, terminals, tolerance)
                    else:
                        text = printed
                        shape.compare(step.lines, text.split("\n"), tolerance)
                except Wrong as e:
                    text = terminals.named(step.terminal).output() if step.terminal else printed
                    raise Wrong(f"line {step.line}: {e}\n-- all that came:\n{text.rstrip()}") from None
                came.append((step, text))
        terminals.end()
    return came


def read(page):
    with open(page, encoding="utf-8") as file:
        try:
            return file.read()
        except UnicodeDecodeError as e:
            raise Wrong(f"this is no UTF-8: {e.reason}") from None


def run_page(page, programs, say=lambda _: None):
    steps = steps_of(read(page))
    with tempfile.TemporaryDirectory(prefix="padr-page-") as folder:
        fresh_folder(folder, programs)
        return run_steps(steps, folder, programs, say)


def most_like(shown, came):
    """Which line has the same words as the shown one and most of its numbers; the first of several."""
    likely = [i for i, line in enumerate(came) if not shape.differs(shown, line, shape.Tolerance())]
    return max(likely, key=lambda i: sum(a == b for a, b in zip(shown.split(), came[i].split())), default=None)


def as_short(shown, came):
    """What came, with its end left out where the page leaves it out."""
    if "..." not in shown:
        return came
    if shown.count("...") > 1 or not shown.endswith("..."):
        return shown
    kept = len(shown[:-3].split())
    return re.match(r"\s*(?:\S+\s+){%d}" % kept, came + " ").group() + "..."


def write_page(page, programs):
    """Puts in the numbers that came."""
    shape.Tolerance.allows = lambda *_: True
    exact, shape.tolerance_of = shape.tolerance_of, lambda *_: shape.Tolerance()
    came = run_page(page, programs)
    shape.tolerance_of = exact
    lines = read(page).split("\n")
    changed = 0
    for step, text in came:
        rest = text.split("\n")
        indent = "" if lines[step.line - 2].startswith("```") else "    "
        for i, shown in enumerate(step.lines):
            if shown == "..." or not shown.strip():
                continue
            place = most_like(shown, rest)
            if place is None:
                continue
            new, rest = as_short(shown, rest[place].rstrip()), rest[place + 1 :]
            changed += new != shown
            lines[step.line - 1 + i] = indent + new
    with open(page, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))
    print(f"{os.path.relpath(page, ROOT)}: {changed} lines changed")


def text_of(page):
    """The page without blocks of code and comments."""
    text = re.sub(r"<!--.*?-->", "", page, flags=re.S)
    text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    return "\n".join(line for line in text.split("\n") if not line.startswith("    "))


def check_page(page, programs):
    """What is wrong with a page without running it."""
    text = read(page)
    blocks = blocks_and_stops(text)
    found = []
    for block in blocks:
        if not block.comment.startswith(("output", "stop")):
            found += [f"line {block.line}: {problem}" for problem in options.problems("\n".join(block.lines), programs)]
    for span in re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text_of(text)):
        found += [f"in `{span}`: {problem}" for problem in options.problems(span, programs, in_a_sentence=True)]
    if os.path.basename(page).startswith("tutorial-"):
        words = len(text_of(text).split())
        if words > MOST_WORDS:
            found.append(f"{words} words, a tutorial has at most {MOST_WORDS}")
        shown = "\n".join(line for block in blocks for line in block.lines)
        plain = re.sub(r"\]\([^)]*\)", "", text_of(text))
        figures = re.findall(r"(?<![\w.])\d+\.\d+(?![\w.])|\b(?=\d*[a-f])(?=[a-f]*\d)[0-9a-f]{8,16}\b", plain)
        found += [f"the figure {n} is in no block of the page" for n in figures if n not in shown]
        steps_of(text)
    return found


def check(pages, programs):
    known = options.Programs(ROOT, programs)
    bad = 0
    for page in pages:
        try:
            found = check_page(page, known)
        except Wrong as e:
            found = [str(e)]
        for problem in found:
            print(f"{os.path.relpath(page, ROOT)}: {problem}")
        bad += bool(found)
    print(f"{len(pages)} documents checked, {bad} wrong")
    return 1 if bad else 0


def main():
    parser = argparse.ArgumentParser(add_help=False)
    parser.error = lambda message: parser.exit(2, f"{parser.prog}: {message} (see --help)\n")
    parser.add_argument("--help", "-h", action="store_true")
    parser.add_argument("--bin", default=os.path.join(ROOT, "build", "release", "bin"))
    parser.add_argument("--patience", type=float, default=shells.patience)
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("what", nargs="?", choices=["run", "write", "check"])
    parser.add_argument("pages", nargs="*")
    args = parser.parse_args()
    if args.help:
        print(__doc__.strip())
        return 0
    if args.what is None:
        parser.error("give run, write or check")
    programs, shells.patience = os.path.abspath(args.bin), args.patience
    if not os.access(os.path.join(programs, "padr-lab"), os.X_OK):
        print(f"doc_commands.py: there is no padr-lab in {args.bin}; build it, or name its folder with --bin", file=sys.stderr)
        return 2
    missing = [page for page in args.pages if not os.path.isfile(page)]
    if missing or (args.what != "check" and not args.pages):
        print(f"doc_commands.py: {f'there is no {missing[0]}' if missing else 'name a page'}", file=sys.stderr)
        return 2
    pages = [os.path.abspath(page) for page in args.pages]
    if args.what == "check":
        everything = [os.path.join(ROOT, "README.md"), os.path.join(ROOT, "CONTRIBUTING.md"), *sorted(glob.glob(os.path.join(ROOT, "docs", "*.md")))]
        return check(pages or everything, programs)
    held = alone_in_the_network(sys.argv[1:])
    status = 0
    for page in pages:
        try:
            if args.what == "write":
                write_page(page, programs)
            else:
                run_page(page, programs, print if args.verbose else lambda _: None)
                print(f"{os.path.relpath(page, ROOT)}: as it says")
        except Wrong as e:
            print(f"{os.path.relpath(page, ROOT)}, {e}")
            status = 1
    del held
    return status


if __name__ == "__main__":
    sys.exit(main())
