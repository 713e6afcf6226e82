"""Running padr-peer processes and talking to them: what the end-to-end tests share.

Everything that waits has a bound. When a test fails, the logs of its peers are printed.
"""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "padr-peer"
PLAYING = r"peers? starts in|: in as peer"  # the log line that says so
PATIENCE = 30.0  # s until something that should happen counts as missing; a loaded machine is slow


class Peer:
    """A running padr-peer. Its log is read by a thread, so that it never blocks on a full pipe."""

    def __init__(self, *arguments, env=None, preexec_fn=None, program=None):
        self.arguments = [str(a) for a in arguments]
        self.json_file = tempfile.NamedTemporaryFile(suffix=".json", delete=False)
        self.json_file.close()
        os.unlink(self.json_file.name)
        self.process = subprocess.Popen(
            [program or PROGRAM, "--json", self.json_file.name, *self.arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace", env=env,
            preexec_fn=preexec_fn,
        )  # fmt: skip
        self.log = []
        self.news = threading.Condition()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            with self.news:
                self.log.append(line.rstrip("\n"))
                self.news.notify_all()
        with self.news:
            self.news.notify_all()

    def text(self):
        with self.news:
            return "\n".join(self.log)

    def wait_for(self, pattern, patience=PATIENCE):
        """The match of the first log line that fits; fails if it does not come, or the peer ends first."""
        deadline = time.monotonic() + patience
        seen = 0
        with self.news:
            while True:
                for line in self.log[seen:]:
                    found = re.search(pattern, line)
                    if found:
                        return found
                seen = len(self.log)
                left = deadline - time.monotonic()
                if left <= 0 or (self.process.poll() is not None and not self.reader.is_alive()):
                    raise AssertionError(f"no line like {pattern!r} in the log of {self.arguments}:\n" + "\n".join(self.log))
                self.news.wait(min(left, 0.2))

    def port(self):
        return int(self.wait_for(r"listening on .*:(\d+)$")[1])

    def end(self, patience=PATIENCE):
        """Waits for it; its exit code."""
        try:
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still running after {patience} s: {self.arguments}\n{self.text()}") from None
        self.reader.join(PATIENCE)
        return self.process.returncode

    def summary(self):
        with open(self.json_file.name, encoding="utf-8") as f:
            return json.load(f)

    def stop(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.reader.join(PATIENCE)
        self.process.stdout.close()
        self.process.stderr.close()
        if os.path.exists(self.json_file.name):
            os.unlink(self.json_file.name)


class Case(unittest.TestCase):
    def setUp(self):
        self.peers = []
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        outcome = self._outcome
        result = getattr(outcome, "result", None)
        failed = result is not None and any(t is self for t, _ in result.failures + result.errors)
        for peer in self.peers:
            peer.stop()
            if failed:
                print(f"--- log of {peer.arguments}, exit {peer.process.returncode}\n{peer.text()}", file=sys.stderr)
        self.folder.cleanup()

    def peer(self, *arguments, **more):
        peer = Peer(*arguments, **more)
        self.peers.append(peer)
        return peer

    def file(self, name, content):
        path = os.path.join(self.folder.name, name)
        with open(path, "wb") as f:
            f.write(content if isinstance(content, bytes) else content.encode())
        return path

    def session(self, count, *arguments, own=None):
        """A founder and count-1 joiners with the same arguments, and own[i] for each by itself."""
        own = own or [[]] * count
        founder = self.peer("--wait-peers", count, *arguments, *own[0])
        port = founder.port()
        return [founder] + [self.peer("--join", f"127.0.0.1:{port}", *arguments, *own[i]) for i in range(1, count)]

    def check_agreement(self, peers, least_common):
        """Confirmed hashes are equal wherever all peers have been in lives that they did not give up."""
        points = [checkpoints(p.summary()) for p in peers]
        common = set(points[0]).intersection(*points[1:])
        self.assertGreaterEqual(len(common), least_common)
        for tick in sorted(common, key=int):
            self.assertEqual(len({p[tick] for p in points}), 1, f"hashes at tick {tick}: {[p[tick] for p in points]}")
        for p in peers:
            self.assertEqual(p.summary()["confirmed"]["mismatches"], 0)


def checkpoints(summary):
    """Confirmed hashes by tick, of the peer's last life."""
    return summary["confirmed"]["checkpoints"]


def differing(summaries):
    """Ticks that two or more have confirmed, and those of them at which they differ."""
    values = {}
    for summary in summaries:
        for tick, value in checkpoints(summary).items():
            values.setdefault(int(tick), []).append(value)
    shared = {tick: v for tick, v in values.items() if len(v) > 1}
    return len(shared), sorted(tick for tick, v in shared.items() if len(set(v)) > 1)


def run(*arguments, patience=PATIENCE):
    """One padr-peer to its end: exit code, standard output, standard error."""
    done = subprocess.run(
        [PROGRAM, *[str(a) for a in arguments]],
        stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", timeout=patience,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def has_ipv6_loopback():
    try:
        with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as s:
            s.bind(("::1", 0))
        return True
    except OSError:
        return False


def main():
    print(f"program: {PROGRAM}")
    unittest.main(verbosity=2)


__all__ = ["Case", "Peer", "PATIENCE", "PLAYING", "checkpoints", "differing", "has_ipv6_loopback", "main", "run", "signal",
           "socket", "time", "unittest"]  # fmt: skip
