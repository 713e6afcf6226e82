"""Running padr-monitor processes and being their browser: what the end-to-end tests share.

The WebSocket client is written from RFC 6455 and knows nothing of the program's own code. Everything that waits has a
bound.
"""

import base64
import hashlib
import http.client
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import threading

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "padr-monitor"

# peers.py takes its program from the command line, too.
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "e2e"))
import peers  # noqa: E402
from waiting import PATIENCE, wait_until  # noqa: E402

main = peers.main


class Monitor:
    """A running padr-monitor."""

    def __init__(self, *arguments, env=None, web="127.0.0.1:0", heard="127.0.0.1:0"):
        env = dict(os.environ if env is None else env)
        # AddressSanitizer keeps what has been freed, and memory() counts it.
        env["ASAN_OPTIONS"] = env.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=1"
        self.process = subprocess.Popen(
            [PROGRAM, "--listen", web, "--peers-listen", heard, *map(str, arguments)],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env,
        )  # fmt: skip
        self.log = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        line = self.process.stdout.readline()
        found = re.fullmatch(r"http://(.+):(\d+)/\n", line)
        if not found:
            self.process.wait(PATIENCE)
            self.reader.join(PATIENCE)
            raise AssertionError(f"no address but {line!r}; it said:\n" + "\n".join(self.log))
        self.host, self.port = found[1], int(found[2])

    def _read(self):
        for line in self.process.stderr:
            self.log.append(line.rstrip("\n"))

    def heard_at(self):
        """Where peers are to send to."""
        return wait_until(lambda: [m[1] for m in map(lambda x: re.search(r"--monitor (\S+)$", x), self.log) if m],
                          "the peers' address")[0]  # fmt: skip

    def get(self, path, method="GET", headers=None):
        """Status, headers, body."""
        connection = http.client.HTTPConnection(self.host, self.port, timeout=PATIENCE)
        try:
            connection.request(method, path, headers=headers or {})
            reply = connection.getresponse()
            return reply.status, reply.headers, reply.read()
        finally:
            connection.close()

    def session(self):
        return json.loads(self.get("/api/session")[2])

    def metrics(self):
        """By name with labels."""
        values = {}
        for line in self.get("/metrics")[2].decode().splitlines():
            if not line.startswith("#"):
                name, _, value = line.rpartition(" ")
                values[name] = float(value)
        return values

    def connect(self):
        return socket.create_connection((self.host, self.port), timeout=PATIENCE)

    def raw(self, request):
        """What comes back to these bytes until the end of the connection."""
        with self.connect() as s:
            s.sendall(request)
            answer = b""
            while True:
                try:
                    part = s.recv(65536)
                except ConnectionResetError:
                    return answer
                if not part:
                    return answer
                answer += part

    def alive(self):
        return self.process.poll() is None

    def memory(self):
        """Resident bytes."""
        with open(f"/proc/{self.process.pid}/statm", encoding="ascii") as f:
            return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def seconds(self):
        """Of processor time used."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as f:
            fields = f.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self, how=signal.SIGINT):
        """Its exit code."""
        self.process.send_signal(how)
        self.process.wait(PATIENCE)
        self.stop()
        return self.process.returncode

    def stop(self):
        if self.alive():
            self.process.kill()
        self.process.wait(PATIENCE)
        self.reader.join(PATIENCE)
        self.process.stdout.close()
        self.process.stderr.close()


class Refused(Exception):
    """No WebSocket came about; has the status."""

    def __init__(self, status):
        super().__init__(f"HTTP status {status}")
        self.status = status


class View:
    """A block of a binary message, as PROTOCOL.md has it."""

    def __init__(self, data, at):
        kind, self.slot, self.which, self.flags, self.tick, self.threshold, x, y, n, zero = struct.unpack_from("<BBBBifffHH", data, at)
        assert kind == 1 and zero == 0, (kind, zero)
        self.target = (x, y)
        self.records = {}
        for i in range(n):
            entity, owner, flags, ex, ey, angle = struct.unpack_from("<HBBfff", data, at + 24 + 16 * i)
            self.records[entity] = (owner, flags, ex, ey, angle)
        self.size = 24 + 16 * n


class Page:
    """A browser's WebSocket. A thread reads; messages are kept by type, views by slot and kind."""

    SHOWN, LIVE, PREDICTED, CONFIRMED, AUTHORITY = range(5)

    def __init__(self, monitor, origin=None, host=None, path="/ws", read=True, headers=()):
        self.socket = monitor.connect()
        key = base64.b64encode(os.urandom(16)).decode()
        host = host or f"{monitor.host}:{monitor.port}"
        lines = [f"GET {path} HTTP/1.1", f"Host: {host}", "Connection: Upgrade", "Upgrade: websocket",
                 "Sec-WebSocket-Version: 13", f"Sec-WebSocket-Key: {key}"]  # fmt: skip
        if origin:
            lines.append(f"Origin: {origin}")
        lines.extend(headers)
        self.socket.sendall("\r\n".join([*lines, "", ""]).encode())
        self.data = b""
        while b"\r\n\r\n" not in self.data:
            part = self.socket.recv(4096)
            if not part:
                raise Refused(0)
            self.data += part
        head, _, self.data = self.data.partition(b"\r\n\r\n")
        status = int(head.split()[1])
        if status != 101:
            self.socket.close()
            raise Refused(status)
        accept = base64.b64encode(hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest())
        assert accept in head, head
        self.lock = threading.Lock()
        self.sending = threading.Lock()
        self.texts = []
        self.views = {}
        self.bytes = 0
        self.binaries = 0
        self.closed = None  # the code, once it is
        self.ids = 0
        if read:
            threading.Thread(target=self._run, daemon=True).start()

    def _take(self, n):
        while len(self.data) < n:
            part = self.socket.recv(65536)
            if not part:
                raise ConnectionError
            self.data += part
        taken, self.data = self.data[:n], self.data[n:]
        return taken

    def _run(self):
        try:
            while self._frame():
                pass
        except (OSError, ConnectionError):
            pass
        with self.lock:
            if self.closed is None:
                self.closed = 1006

    def _frame(self):
        first, second = self._take(2)
        size = second & 127
        if size == 126:
            size = struct.unpack(">H", self._take(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self._take(8))[0]
        payload = self._take(size)
        assert first & 128, "messages come in one frame"
        opcode = first & 15
        with self.lock:
            self.bytes += size
            if opcode == 1:
                self.texts.append(json.loads(payload))
            elif opcode == 2:
                self.binaries += 1
                at = 0
                while at < size:
                    view = View(payload, at)
                    self.views.setdefault((view.slot, view.which), []).append(view)
                    at += view.size
            elif opcode == 8:
                self.closed = struct.unpack(">H", payload[:2])[0] if size >= 2 else 1005
                return False
        if opcode == 9:
            self.frame(10, payload)
        return True

    def frame(self, opcode, payload, final=True, masked=True):
        head = bytes([opcode | (128 if final else 0)])
        bit = 128 if masked else 0
        if len(payload) < 126:
            head += bytes([len(payload) | bit])
        elif len(payload) < 65536:
            head += struct.pack(">BH", 126 | bit, len(payload))
        else:
            head += struct.pack(">BQ", 127 | bit, len(payload))
        if masked:
            mask = os.urandom(4)
            payload = mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        with self.sending:
            self.socket.sendall(head + payload)

    def say(self, **message):
        self.frame(1, json.dumps(message).encode())

    def ask(self, **message):
        """The answer to it."""
        self.ids += 1
        message["id"] = self.ids
        self.say(**message)
        return self.wait("answer", lambda a: a["id"] == message["id"])

    def all(self, kind):
        with self.lock:
            return [t for t in self.texts if t["type"] == kind]

    def wait(self, kind, fits=lambda t: True, patience=PATIENCE):
        """The newest message of the kind that fits."""
        return wait_until(lambda: [t for t in self.all(kind) if fits(t)], f"a message '{kind}' that fits", patience)[-1]

    def until(self, kind, fits):
        """Waits until the newest message of the kind fits, whatever came before."""
        wait_until(lambda: any(map(fits, self.all(kind)[-1:])), f"a newest message '{kind}' that fits")

    def events(self):
        return [e for message in self.all("events") for e in message["events"]]

    def newest(self, slot, which=0):
        with self.lock:
            views = self.views.get((slot, which))
            return views[-1] if views else None

    def wait_view(self, slot, which=0, fits=lambda v: True):
        return wait_until(lambda: (lambda v: v if v and fits(v) else None)(self.newest(slot, which)), f"view {which} of slot {slot}")

    def wait_closed(self, patience=PATIENCE):
        return wait_until(lambda: self.closed, "the end of the connection", patience)

    def close(self):
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.socket.close()


class MonitorCase(peers.Case):
    def setUp(self):
        super().setUp()
        self.monitors, self.pages = [], []

    def tearDown(self):
        for page in self.pages:
            page.close()
        for m in self.monitors:
            m.stop()
        super().tearDown()

    def monitor(self, *arguments, **options):
        m = Monitor(*arguments, **options)
        self.monitors.append(m)
        return m

    def page(self, monitor, **options):
        p = Page(monitor, **options)
        self.pages.append(p)
        return p

    def watched(self, monitor, count, *arguments, own=None):
        """Peers that play and tell the monitor."""
        played = self.session(count, "--status-interval", 0, "--monitor", monitor.heard_at(), *arguments, own=own)
        for p in played:
            p.wait_for(peers.PLAYING)
        return played


def refused(*arguments, env=None):
    """Exit code and what it says, of a monitor that does not start."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=PATIENCE, env=env)  # fmt: skip
    return done.returncode, done.stderr
