"""Terminals in which a page's commands are run: a shell each, whose folder and variables stay as a reader's would."""

import os
import select
import signal
import subprocess
import time

from pages import Wrong

patience = 240.0  # s until what should end or come counts as missing


class Terminal:
    def __init__(self, name, folder, environment):
        self.name = name
        self.log = os.path.join(folder, "." + name.replace(" ", "-") + ".log")
        self.statuses, written = os.pipe()
        with open(self.log, "ab") as log:
            self.shell = subprocess.Popen(
                ["bash", "--norc"], stdin=subprocess.PIPE, stdout=log, stderr=log, cwd=folder, env=environment,
                pass_fds=[written], start_new_session=True,
            )  # fmt: skip
        self.status_fd = written
        os.close(written)
        self.begin = 0  # where in the log the latest command's output begins
        self.running = None  # the command that has not ended yet
        # A Ctrl-C is for the program in front, not for the shell.
        self.shell.stdin.write(b"trap : INT\n")
        self.shell.stdin.flush()

    def start(self, command):
        self.begin = os.path.getsize(self.log)
        self.running = command
        text = f"{{ {command.text}\n}} </dev/null {self.status_fd}>&-\necho $? >&{self.status_fd}\n"
        self.shell.stdin.write(text.encode())
        self.shell.stdin.flush()

    def output(self):
        with open(self.log, "rb") as log:
            log.seek(self.begin)
            return log.read().decode(errors="replace")

    def ended(self, seconds):
        """The status of the command that runs here, or None if it has not ended after so many seconds."""
        ready, _, _ = select.select([self.statuses], [], [], seconds)
        if not ready:
            return None
        return int(os.read(self.statuses, 100).split()[0])

    def ended_by_now(self):
        return bool(select.select([self.statuses], [], [], 0)[0])

    def wait(self):
        if not self.running:
            return
        command, status = self.running, self.ended(patience)
        self.running = None
        if status is None:
            raise Wrong(f"line {command.line}: '{command.text}' still ran after {patience:g} s")
        if status != command.how.status:
            raise Wrong(
                f"line {command.line}: '{command.text}' exited with {status}, should with {command.how.status}; it said:\n{self.output()}"
            )

    def stop(self):
        """Ctrl-C, as a reader gives it."""
        if self.running:
            os.killpg(self.shell.pid, signal.SIGINT)
            self.wait()

    def close(self):
        try:
            os.killpg(self.shell.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.shell.wait()
        os.close(self.statuses)


class Terminals:
    def __init__(self, folder, environment):
        self.folder, self.environment = folder, environment
        self.all = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for terminal in self.all.values():
            terminal.close()

    def named(self, name):
        if name not in self.all:
            self.all[name] = Terminal(name, self.folder, self.environment)
        return self.all[name]

    def wait_for_what_ends(self):
        for terminal in self.all.values():
            if terminal.running and not (terminal.running.how.until_stopped or terminal.running.how.seconds):
                terminal.wait()

    def run(self, commands):
        """Runs a block's commands; what they printed where the reader is."""
        printed, stops = "", []
        for command in commands:
            if not command.how.terminal:
                self.wait_for_what_ends()
            terminal = self.named(command.how.terminal or "here")
            terminal.wait()
            terminal.start(command)
            if command.how.seconds:
                stops.append((time.monotonic() + command.how.seconds, terminal))
            if not command.how.terminal:
                terminal.wait()
                printed += terminal.output()
        for when, terminal in stops:
            time.sleep(max(0.0, when - time.monotonic()))
            terminal.stop()
        return printed

    def end(self):
        for terminal in self.all.values():
            if terminal.running and terminal.running.how.until_stopped:
                terminal.stop()
        self.wait_for_what_ends()
