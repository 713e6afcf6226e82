"""Whether the commands that documents show are there: programs, their subcommands and their options, as --help has them."""

import os
import re
import subprocess

SHELL_WORD = re.compile(r"""(?:'[^']*'|"(?:\\.|[^"\\])*"|\\.|\$\([^)]*\)|[^\s'"\\|;&()<>`]|[<>](?=\())+|[|;&()<>`]+|\n""")
SKIPPED = re.compile(r"^(\$|sudo|time|timeout|nice|exec|parallel|eval|env|do|then|\w+=\S*|\d+[a-z]?)$")
PROGRAM = re.compile(r"^(?:(?:\./)?(?:build/\w+/bin/)?(?P<program>padr-[a-z]+)|(?:\./)?(?P<script>(?:tools|tests|examples|\.ci)/[\w./-]+|\.ci/run))$")


class Programs:
    """What the programs and scripts of the project say of themselves."""

    def __init__(self, root, folder):
        self.root, self.folder, self.known = root, folder, {}

    def path(self, program, script):
        return os.path.join(self.root, script) if script else os.path.join(self.folder, program)

    def said(self, path, *words):
        key = (path, *words)
        if key not in self.known:
            command = ["python3", "-B", path] if path.endswith(".py") else [path]
            done = subprocess.run([*command, *words, "--help"], capture_output=True, text=True, timeout=60, check=False, stdin=subprocess.DEVNULL)
            self.known[key] = done.stdout if done.returncode == 0 else ""
        return self.known[key]

    def subcommands(self, path):
        listed = self.said(path).partition("\nSubcommands:\n")[2]
        return set(re.findall(r"^  ([a-z][a-z-]*) ", listed, re.M)) | set(re.findall(r"^  padr-peer (keygen|fingerprint)", self.said(path), re.M))


def options_of(text, whole):
    """Options that a help text has: of the C++ programs those that begin a line, of scripts all that it names."""
    pattern = r"(?<![\w-])--[a-z][a-z0-9-]*" if whole else r"^  (?:-\w,)?--[a-z][a-z0-9-]*"
    return {"--" + found.partition("--")[2] for found in re.findall(pattern, text, re.M)} | {"--help"}


def uses(text):
    """Programs and scripts of the project in a block, each with the words behind it."""
    text = re.sub(r"\\\n\s*", " ", text)
    found, current, first = [], None, True
    for token in SHELL_WORD.findall(text):
        if re.fullmatch(r"[|;&()`\n]+", token):
            current, first = None, True
            continue
        if token.startswith("#"):
            current, first = None, False
            continue
        if first:
            if SKIPPED.match(token):
                continue
            match = PROGRAM.match(token)
            current = [match["program"], match["script"], []] if match else None
            if match:
                found.append(current)
            first = False
        elif current and token.startswith("("):
            current = None
        elif current:
            current[2].append(token)
    return found


def problems(text, programs, in_a_sentence=False):
    """What is wrong with the commands in a block, a sentence each. A sentence may leave out the subcommand."""
    found = []
    for program, script, words in uses(text):
        if in_a_sentence and not words:
            continue
        path = programs.path(program, script)
        name = program or script
        if not os.path.exists(path):
            found.append(f"there is no {name}")
            continue
        options = {word.split("=")[0] for word in words if re.match(r"--[a-z]", word)}
        if not options and not program:
            continue
        sub = []
        subcommands = programs.subcommands(path) if program else set()
        if subcommands and words and re.fullmatch(r"[a-z]+", words[0]) and words[0] != "...":
            if words[0] not in subcommands:
                found.append(f"{name} has no subcommand '{words[0]}'")
                continue
            sub = [words[0]]
        known = options_of(programs.said(path, *sub), whole=not program)
        for other in sorted(subcommands) if in_a_sentence and not sub else []:
            known |= options_of(programs.said(path, other), whole=False)
        if script and not programs.said(path):
            continue  # a script without --help
        found += [f"{' '.join([name, *sub])} has no option {option}" for option in sorted(options - known)]
    return found
