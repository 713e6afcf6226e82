"""What a program's --help says, as data: its commands, its options and the values that they take."""

import re
import subprocess
from dataclasses import dataclass, field

OPTION = re.compile(r"^  (?:(-\w),\s?)?(--[a-z][\w-]*)(?: ((?:\S| (?! ))+))?(?:\s{2,}(.*))?$")
COMMAND = re.compile(r"^  ([a-z]+) {2,}(\S.*)$")
# Names in a sentence, at its beginning or behind a colon or a full stop: with commas or "or" between them, and remarks in
# parentheses behind them.
NAME = r"[a-z0-9][a-z0-9-]*(?: \([^)]*\))?"
LIST = re.compile(rf"(?:^|[:.] )((?:{NAME}, )*{NAME},? or {NAME}|(?:{NAME}, )+{NAME})(?=$|[;:.,]|\s+\(default)")
ALTERNATIVES = re.compile(r"^[a-z][a-z0-9-]*(?:\|[a-z][a-z0-9-]*)+")


@dataclass
class Option:
    name: str
    takes: str  # what --help calls the value; "" for a flag
    text: str
    values: list = field(default_factory=list)

    @property
    def kind(self):
        """file, folder, or nothing that a shell could complete."""
        if re.search(r"\bFILE\b", self.takes):
            return "file"
        return "folder" if re.search(r"\b(DIR|FOLDER)\b", self.takes) else ""


@dataclass
class Help:
    text: str
    options: list
    commands: dict  # name: what it is
    files: bool  # whether it takes files without a flag


def said(command, how="--help"):
    """What a program says of itself. Raises if it does not."""
    return subprocess.run([*command, how], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True).stdout


def names_in(sentence):
    """The names of the first list in a sentence: "Which: first, second (order) or input" has three."""
    found = LIST.search(sentence)
    return re.findall(r"[a-z0-9][a-z0-9-]*", re.sub(r"\([^)]*\)|\bor\b", "", found[1])) if found else []


def values_of(takes, text):
    """The values that --help names: on|off, {on,off}, or a list in the text of an option that takes a name."""
    braces = re.search(r"\{([^}]*)\}", takes)
    if braces:
        return braces[1].split(",")
    if ALTERNATIVES.match(takes):
        return ALTERNATIVES.match(takes)[0].split("|")
    word = re.match(r"^[A-Z]+\|([a-z]+)\b", takes)  # M|off: a number, or a word
    if word:
        return [word[1]]
    if not re.match(r"^(NAMES?|MODE|LEVEL|LIST)(?!=[A-Z])\b", takes):
        return []
    default = re.search(r"=([a-z][a-z0-9-]*(?:,[a-z0-9-]+)*)$", takes)
    return names_in(text) or (default[1].split(",") if default else [])


def read(text):
    """The options and commands of a --help text."""
    options, commands, section = [], {}, ""
    open_option = None  # whose text may go on in the next line
    for line in text.splitlines():
        match = OPTION.match(line)
        if match:
            open_option = Option(match[2], match[3] or "", match[4] or "")
            options.append(open_option)
        elif open_option and re.match(r"^ {8,}\S", line):
            open_option.text = (open_option.text + " " + line.strip()).strip()
        else:
            open_option = None
            if re.match(r"^\S.*:$", line):
                section = line
            elif section == "Subcommands:" and COMMAND.match(line):
                commands[COMMAND.match(line)[1]] = COMMAND.match(line)[2]
    for option in options:
        option.values = values_of(option.takes, option.text)
    usage = re.search(r"^[Uu]sage: (.*)$", text, re.M)
    files = bool(usage and re.search(r"\b(FILE|TRACE|CAPTURE|SHARD)\b", usage[1]))
    return Help(text, options, commands, files)


def commands_of(program):
    """{command: Help} of a program; the command "" is the program without one."""
    top = read(said([program]))
    found = {"": top}
    for name in top.commands:
        found[name] = read(said([program, name]))
    return found
