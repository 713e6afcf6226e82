"""How tables and pictures are measured: padr-lab is run, whole or in a short form, and what it wrote is read."""

import csv
import json
import os
import shlex
import shutil
import subprocess
import tempfile


class Failed(Exception):
    """A measurement that did not come about."""


class Measuring:
    """Runs padr-lab. Give the whole value and the short one as a pair where they differ: ("1-40", "1-2")."""

    def __init__(self, programs, quick):
        self.programs = programs
        self.quick = quick
        self.commands = []  # as a reader would give them
        self._shown = {}  # them, by what is run
        self._done = {}
        self._folder = tempfile.mkdtemp()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self._folder, ignore_errors=True)

    def begin(self):
        self.commands = []
        self._shown = {}

    def _chosen(self, words):
        return [w[1 if self.quick else 0] if isinstance(w, tuple) else w for w in words]

    def _as_shown(self, chosen):
        """A sweep goes on with the rows in its file, and refuses those of another grid: each has a file of its own."""
        shown = shlex.join(["padr-lab", *(w for w in chosen if w != "--no-pictures")])
        before = sum(c.split()[1] == chosen[0] for c in self.commands)
        file = f"out/{chosen[0]}{f'-{before + 1}' if before else ''}.csv"
        return shown.replace("OUT", "out/" + chosen[0]).replace("FILE", file)

    def lab(self, *words):
        """Runs padr-lab; returns what it printed. The word OUT stands for a folder of its own, FILE for a file in it."""
        chosen = self._chosen(words)
        key = tuple(chosen)
        if key not in self._shown:
            self._shown[key] = self._as_shown(chosen)
            self.commands.append(self._shown[key])
        if key in self._done:
            return self._done[key]
        folder = os.path.join(self._folder, str(len(self._done)))
        os.mkdir(folder)
        command = [os.path.join(self.programs, "padr-lab")]
        command += [w.replace("OUT", folder).replace("FILE", os.path.join(folder, "rows.csv")) for w in chosen]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        if done.returncode != 0:
            raise Failed(f"{self._shown[key]} ended with {done.returncode}: {done.stderr.decode().strip()[-400:]}")
        self._done[key] = (done.stdout.decode(), folder)
        return self._done[key]

    def sweep(self, *words):
        """The rows of a sweep, as dictionaries."""
        _, folder = self.lab("sweep", *words, "--csv", "FILE")
        with open(os.path.join(folder, "rows.csv"), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def json(self, *words):
        return json.loads(self.lab(*words, "--json", "-")[0])

    def folder(self, *words):
        """Where the command has put its files."""
        return self.lab(*words, "--out", "OUT")[1]


def mean(rows, column):
    return sum(float(r[column]) for r in rows) / len(rows)


def interval(rows, column):
    """Half of the 95 % interval of the mean (normal approximation)."""
    if len(rows) < 2:
        return 0.0
    m = mean(rows, column)
    variance = sum((float(r[column]) - m) ** 2 for r in rows) / (len(rows) - 1)
    return 1.96 * (variance / len(rows)) ** 0.5


def metres(value):
    """With as many digits as say something."""
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}" if value >= 1 else f"{value:.3f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(r) + " |" for r in rows])
