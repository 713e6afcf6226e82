"""What a page of Markdown has for the runner: blocks of code, and comments that say how they are run.

A comment stands alone before its block and is invisible to readers:

  <!-- run: in terminal 1 -->            how the block's commands are run; without a comment: one after the other
  <!-- not run: why -->                  the block is not run; its programs and options are checked all the same
  <!-- run:                              for single commands of a block: text that is in exactly one of them => how
  padr-monitor => in terminal 3; for 2 s
  docker compose => not run, it needs a container engine
  -->
  <!-- output: within 30 % -->           the block is what the commands before it print
  <!-- output of terminal 1 -->          what the latest command of that terminal has printed; it may still run
  <!-- stop: terminal 1 -->              Ctrl-C there; stands without a block

A table that tools/figures.py makes has its own commands, which another test repeats: they are not run.
"""

import re
import shlex
import subprocess
from dataclasses import dataclass, field


class Wrong(Exception):
    """A page that does not hold what it says, or whose comments make no sense."""


@dataclass
class How:
    """How a command is run."""

    terminal: str = ""  # empty: where the reader is; it is waited for
    until_stopped: bool = False
    seconds: float = 0.0  # Ctrl-C after so long; 0: it ends by itself
    shorter: str = ""  # options that replace or follow the page's own
    status: int = 0
    not_run: str = ""


@dataclass
class Command:
    text: str
    line: int
    how: How


@dataclass
class Step:
    """One thing that a reader does or sees."""

    kind: str  # run, output or stop
    line: int
    commands: list = field(default_factory=list)
    lines: list = field(default_factory=list)
    terminal: str = ""
    tolerance: str = ""


@dataclass
class Block:
    line: int  # number of its first line
    lines: list
    comment: str = ""


LIST_ITEM = re.compile(r"\s*([-*+]|\d+[.)])\s")
OURS = re.compile(r"(not run|run|output|stop)\b")


def blocks_and_stops(text):
    """Blocks of code and `stop` comments of a page in order, each block with its comment."""
    found, comment, made, lines, i, listed = [], "", "", text.split("\n"), 0, False
    while i < len(lines):
        line = lines[i]
        if line.startswith("<!--"):
            start = i
            while "-->" not in lines[i]:
                i += 1
                if i == len(lines):
                    raise Wrong(f"line {start + 1}: a comment has no end")
            words = "\n".join(lines[start : i + 1])
            words = words[len("<!--") : words.index("-->")].strip()
            if OURS.match(words):
                if comment:
                    raise Wrong(f"line {start + 1}: no block follows '<!-- {comment} -->'")
                if words.startswith("stop"):
                    found.append(Block(start + 1, [], words))
                else:
                    comment = words
            elif words.startswith("figures "):
                made = "not run: tools/figures.py runs it to make this table"
            elif words.startswith("end "):
                made = ""
        elif line.startswith("```"):
            start = i + 1
            while i + 1 < len(lines) and not lines[i + 1].startswith("```"):
                i += 1
            found.append(Block(start + 1, lines[start : i + 1], comment or made))
            comment, i = "", i + 1
        elif line.startswith("    ") and line.strip() and not listed:
            start = i
            while i + 1 < len(lines) and (lines[i + 1].startswith("    ") or not lines[i + 1].strip()):
                i += 1
            block = [entry[4:].rstrip() for entry in lines[start : i + 1]]
            while block and not block[-1]:
                block.pop()
            found.append(Block(start + 1, block, comment or made))
            comment = ""
        elif line.strip():
            listed = bool(LIST_ITEM.match(line)) or (listed and line.startswith(" "))
            if comment:
                raise Wrong(f"line {i + 1}: no block follows '<!-- {comment} -->'")
        i += 1
    if comment:
        raise Wrong(f"no block follows '<!-- {comment} -->'")
    return found


def complete(text):
    """Whether a shell has what it needs to run the text."""
    if text.endswith("\\"):
        return False
    done = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True, check=False)
    return done.returncode == 0 and "here-document" not in done.stderr


def commands_of(block):
    """The commands of a block; one may go over several lines."""
    commands, held, first = [], "", 0
    for number, line in enumerate(block.lines):
        if not held and (not line.strip() or line.lstrip().startswith("#")):
            continue
        if not held:
            first = block.line + number
        held = f"{held}\n{line}" if held else line
        if complete(held):
            commands.append((first, held))
            held = ""
    if held:
        raise Wrong(f"line {first}: no shell can run '{held.splitlines()[0]}'")
    return commands


def how_of(words, line):
    """What a comment says after `run:`, or after the `=>` of one command."""
    how = How()
    if words.strip().startswith("not run, "):
        how.not_run = words.split(",", 1)[1].strip()
        return how
    for item in filter(None, (w.strip() for w in words.split(";"))):
        match = re.fullmatch(
            r"in (?P<terminal>terminal \d+)|(?P<until>until stopped)|for (?P<seconds>[\d.]+) s|shorter by (?P<shorter>--.*)"
            r"|exit (?P<status>\d+)",
            item,
            re.S,
        )
        if not match:
            raise Wrong(f"line {line}: '{item}' is none of: in terminal N, until stopped, for N s, shorter by OPTIONS, exit N; or 'not run, WHY'")
        how.terminal = match["terminal"] or how.terminal
        how.until_stopped = bool(match["until"]) or how.until_stopped
        how.seconds = float(match["seconds"] or how.seconds)
        how.shorter = match["shorter"] or how.shorter
        how.status = int(match["status"] or how.status)
    if (how.until_stopped or how.seconds) and not how.terminal:
        raise Wrong(f"line {line}: what is stopped needs a terminal of its own")
    return how


def run_step(block):
    words = block.comment
    commands = commands_of(block)
    if words.startswith("not run:"):
        why = words.split(":", 1)[1].strip()
        if len(why) < 10:
            raise Wrong(f"line {block.line}: 'not run:' needs a reason")
        return Step("run", block.line, [Command(text, line, How(not_run=why)) for line, text in commands])
    words = words.split(":", 1)[1] if ":" in words else ""
    if "=>" not in words:
        return Step("run", block.line, [Command(text, line, how_of(words, block.line)) for line, text in commands])
    hows = {}
    for entry in filter(None, (w.strip() for w in words.split("\n"))):
        key, _, rest = entry.partition("=>")
        meant = [line for line, text in commands if key.strip() in text]
        if len(meant) != 1:
            raise Wrong(f"line {block.line}: '{key.strip()}' is in {len(meant)} commands of the block, must be in one")
        hows[meant[0]] = how_of(rest, block.line)
    return Step("run", block.line, [Command(text, line, hows.get(line, How())) for line, text in commands])


def steps_of(text):
    """What a reader of the page does and sees, in order."""
    steps = []
    for block in blocks_and_stops(text):
        words = block.comment
        if words.startswith("stop"):
            match = re.fullmatch(r"stop: (terminal \d+)", words)
            if not match:
                raise Wrong(f"line {block.line}: '{words}' must be 'stop: terminal N'")
            steps.append(Step("stop", block.line, terminal=match[1]))
        elif words.startswith("output"):
            match = re.fullmatch(r"output(?: of (?P<terminal>terminal \d+))?(?:: (?P<tolerance>.*))?", words, re.S)
            if not match:
                raise Wrong(f"line {block.line}: '{words}' must be 'output: HOW' or 'output of terminal N: HOW'")
            steps.append(Step("output", block.line, lines=block.lines, terminal=match["terminal"] or "", tolerance=match["tolerance"] or ""))
        else:
            steps.append(run_step(block))
    return steps


def shortened(text, options):
    """A command with options in place of its own of the same names, or behind them."""
    if not options:
        return text
    command, _, comment = re.sub(r"\\\n\s*", "", text).partition(" #")
    words = shlex.split(options)
    i = 0
    while i < len(words):
        takes = i + 1 < len(words) and not words[i + 1].startswith("--")
        new = words[i] + (" " + shlex.quote(words[i + 1]) if takes else "")
        pattern = re.escape(words[i]) + (r"[ =]('[^']*'|\"[^\"]*\"|\S+)" if takes else r"\b")
        command, count = re.subn(r"(?<=\s)" + pattern, lambda _, new=new: new, command)
        if not count:
            command = f"{command.rstrip()} {new}"
        i += 2 if takes else 1
    return command
