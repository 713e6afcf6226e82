"""A folder with stand-ins for programs, which come before the real ones on PATH."""

import os
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = sys.argv.pop(1) if len(sys.argv) > 1 else os.getcwd()
PATIENCE = 60  # s; a loaded machine is slow


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.mkdir(self.path("bin"))

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def put(self, name, text):
        """A script of that name below the folder."""
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as f:
            f.write(text)
        os.chmod(self.path(name), 0o755)

    def borrow(self, name, file=None):
        """The repository's file of that name, or another one, at that place below the folder."""
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        os.symlink(os.path.join(REPOSITORY, file or name), self.path(name))

    def text(self, name):
        with open(self.path(name), encoding="utf-8") as f:
            return f.read()

    def environment(self, **more):
        return {**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"], **more}

    def run_script(self, *command, **more):
        return subprocess.run(command, cwd=self.folder, env=self.environment(**more), stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False, timeout=PATIENCE)  # fmt: skip
