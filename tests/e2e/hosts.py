"""Machines as network namespaces, for end-to-end tests.

Nothing of the machine that runs the test is changed: switches are bridges in namespaces of their own, so no frame passes
the machine's own firewall, and all goes with the namespaces.
"""

import contextlib
import ctypes
import itertools
import os
import shutil
import subprocess
import sys

from peers import main

SKIPPED = 77  # ctest's SKIP_RETURN_CODE
CLONE_NEWNET = 0x40000000
LIBC = ctypes.CDLL(None, use_errno=True)
NUMBERS = itertools.count()


def ip(*words):
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


def setns(fd):
    """The calling thread goes to another namespace."""
    if LIBC.setns(fd, CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "setns")


@contextlib.contextmanager
def opened(path):
    fd = os.open(path, os.O_RDONLY)
    try:
        yield fd
    finally:
        os.close(fd)


class Network:
    """Namespaces by short names of the test's own, and cables between them."""

    def __init__(self):
        self.prefix = f"padr{os.getpid()}n{next(NUMBERS)}"
        self.names = []

    def name(self, machine):
        return self.prefix + machine

    def path(self, machine):
        return f"/run/netns/{self.name(machine)}"

    def add(self, machine):
        ip("netns", "add", self.name(machine))
        self.names.append(machine)
        self.ip(machine, "link", "set", "lo", "up")

    def ip(self, machine, *words):
        ip("-n", self.name(machine), *words)

    def add_switch(self, machine, device):
        self.ip(machine, "link", "add", "name", device, "type", "bridge")
        self.ip(machine, "link", "set", "dev", device, "up")

    def plug(self, machine, device, switch_machine, switch, port):
        """A cable from a new device of a machine to a new port of a switch."""
        other_end = ("peer", "name", device, "netns", self.name(machine))
        self.ip(switch_machine, "link", "add", "name", port, "type", "veth", *other_end)
        self.ip(switch_machine, "link", "set", "dev", port, "master", switch, "up")
        self.ip(machine, "link", "set", "dev", device, "up")

    def enter(self, machine):
        """For a child process, before it becomes another program."""
        path = self.path(machine)

        def go():
            with opened(path) as namespace:
                setns(namespace)

        return go

    @contextlib.contextmanager
    def inside(self, machine):
        """Sockets that this thread makes meanwhile are the machine's, and stay so."""
        with opened("/proc/thread-self/ns/net") as before, opened(self.path(machine)) as namespace:
            setns(namespace)
            try:
                yield
            finally:
                setns(before)

    def run(self, machine, *command, text=None):
        """What a program prints that runs on the machine."""
        more = {"input": text, "preexec_fn": self.enter(machine)}
        return subprocess.run(command, check=True, capture_output=True, text=True, **more).stdout

    def remove(self):
        for machine in self.names:
            subprocess.run(["ip", "netns", "del", self.name(machine)], check=False, capture_output=True)
        self.names = []


class Machines(Network):
    """Machines 1 .. n with the addresses 10.99.0.1 .. n, and machine 0 with the switch between them."""

    def __init__(self, n):
        super().__init__()
        try:
            for i in range(n + 1):
                self.add(str(i))
            self.add_switch("0", "switch")
            for i in range(1, n + 1):
                self.plug(str(i), "eth0", "0", "switch", f"port{i}")
                self.ip(str(i), "addr", "add", f"10.99.0.{i}/24", "dev", "eth0")
        except BaseException:
            self.remove()
            raise

    def keep_apart(self, *machines):
        """None of these reaches another one of them any more; all others do."""
        for i in machines:
            self.ip("0", "link", "set", f"port{i}", "type", "bridge_slave", "isolated", "on")

    def together(self, *machines):
        for i in machines:
            self.ip("0", "link", "set", f"port{i}", "type", "bridge_slave", "isolated", "off")

    def enter(self, machine):
        return super().enter(str(machine))


def why_no_namespaces():
    """Empty if there can be some."""
    if shutil.which("ip") is None:
        return "there is no program 'ip' (Debian: iproute2)"
    try:
        Machines(1).remove()
    except subprocess.CalledProcessError as error:
        return f"network namespaces are not permitted: '{' '.join(error.cmd)}' says {error.stderr.strip()!r}"
    return ""


def main_unless(reason):
    if reason:
        print(f"skipped: {reason}; as root it runs", file=sys.stderr)
        sys.exit(SKIPPED)
    main()
