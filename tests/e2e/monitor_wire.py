"""A monitor in a few lines: receives what padr-peer --monitor tells and gives orders, from proto/monitor.proto alone."""

import socket
import struct
import threading
import time

PREAMBLE = b"PMON\x01"
MOST_BYTES = 1200
KINDS = {2: "hello", 3: "scenario", 4: "frame", 5: "agreed", 6: "status", 7: "events"}
EVENTS = ["contact_begin", "contact_end", "authority", "release", "joined", "left", "removed", "life", "end", "mismatch",
          "drive", "drive_end", "knob", "netem", "cut", "cut_end", "pause", "pause_end", "push", "refused"]  # fmt: skip


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7


def fields(data):
    """All fields of a message: number to the list of its values; numbers as they are on the wire."""
    out = {}
    at = 0
    while at < len(data):
        key, at = varint(data, at)
        number, kind = key >> 3, key & 7
        if kind == 0:
            value, at = varint(data, at)
        elif kind == 1:
            value, at = struct.unpack_from("<Q", data, at)[0], at + 8
        elif kind == 5:
            value, at = struct.unpack_from("<I", data, at)[0], at + 4
        else:
            length, at = varint(data, at)
            value, at = data[at : at + length], at + length
            assert len(value) == length
        out.setdefault(number, []).append(value)
    return out


def zigzag(v):
    return (v >> 1) ^ -(v & 1)


def column(data, signed=True):
    out, at = [], 0
    while at < len(data):
        value, at = varint(data, at)
        out.append(zigzag(value) if signed else value)
    return out


def number(message, field, otherwise=0):
    return message.get(field, [otherwise])[0]


def real(message, field):
    return struct.unpack("<f", struct.pack("<I", number(message, field)))[0]


def put_varint(v):
    out = b""
    while v >= 0x80:
        out += bytes([v & 0x7F | 0x80])
        v >>= 7
    return out + bytes([v])


def put(field, value):
    """A field: int as varint, float as four bytes, bytes as they are, ("fixed64", int)."""
    if isinstance(value, bool) or isinstance(value, int):
        return put_varint(field << 3) + put_varint(int(value))
    if isinstance(value, float):
        return put_varint(field << 3 | 5) + struct.pack("<f", value)
    if isinstance(value, tuple):
        return put_varint(field << 3 | 1) + struct.pack("<Q", value[1])
    data = value.encode() if isinstance(value, str) else value
    return put_varint(field << 3 | 2) + put_varint(len(data)) + data


class Frame:
    def __init__(self, message):
        self.tick = number(message, 1)
        self.threshold = real(message, 2)
        self.target = (zigzag(number(message, 3)) / 1e3, zigzag(number(message, 4)) / 1e3)
        self.driven = bool(number(message, 5) & 1)
        self.first = number(message, 9)
        self.total = number(message, 10)
        flags = message.get(11, [b""])[0]
        owners = message.get(12, [b""])[0]
        shown, live, predicted = (column(message.get(n, [b""])[0]) for n in (13, 14, 15))
        assert len(flags) == len(owners) and len(shown) == 3 * len(flags)
        self.details = 1 + bool(live) + bool(predicted)
        self.shown, self.live, self.present = {}, {}, {}
        for i in range(len(flags)):
            e = self.first + i
            self.present[e] = bool(flags[i] & 1)
            self.shown[e] = (shown[3 * i] / 1e3, shown[3 * i + 1] / 1e3)
            if live:
                self.live[e] = tuple((shown[3 * i + k] + live[3 * i + k]) / 1e3 for k in (0, 1))


class Teller:
    """What one process has told."""

    def __init__(self, process, address):
        self.process, self.address = process, address
        self.slot = self.token = self.hello = self.status = None
        self.frames, self.events, self.agreed, self.count, self.pieces = [], {}, {}, {}, {}

    def take(self, origin, kind, message):
        slot = number(origin, 3)
        self.slot = slot - 1 if slot else None
        self.count[kind] = self.count.get(kind, 0) + 1
        if kind == "hello":
            self.hello = message
            self.token = number(message, 3)
        elif kind == "scenario":
            self.pieces[number(message, 3)] = message.get(4, [b""])[0]
        elif kind == "frame":
            frame = Frame(message)
            same = self.frames and self.frames[-1].tick == frame.tick
            if same:
                for mine, more in ((self.frames[-1].shown, frame.shown), (self.frames[-1].live, frame.live)):
                    mine.update(more)
            else:
                self.frames.append(frame)
        elif kind == "agreed":
            self.agreed[number(message, 1)] = number(message, 2)
        elif kind == "status":
            self.status = message
        elif kind == "events":
            for raw in message.get(1, []):
                e = fields(raw)
                self.events[number(e, 1)] = {
                    "tick": number(e, 2), "kind": EVENTS[number(e, 3)], "entity": number(e, 4) - 1,
                    "peer": number(e, 5) - 1, "order": number(e, 6), "text": e.get(7, [b""])[0].decode(),
                }  # fmt: skip

    def avatar(self):
        """Entity of its own avatar."""
        return self.frames[-1].total - number(self.hello, 5) + self.slot

    def answers(self, order):
        return [e for e in self.events.values() if e["order"] == order]


class Monitor:
    def __init__(self, port=0):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.socket.bind(("127.0.0.1", port))
        self.socket.settimeout(0.2)
        self.tellers = {}
        self.bad = []
        self.issuer = int.from_bytes(struct.pack("<d", time.time()), "little") | 1
        self.order_number = 0
        self.lock = threading.Condition()
        self.ending = False
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()

    def port(self):
        return self.socket.getsockname()[1]

    def _read(self):
        while not self.ending:
            try:
                data, address = self.socket.recvfrom(65536)
            except TimeoutError:
                continue
            except OSError:
                return
            with self.lock:
                try:
                    self._take(data, address)
                except Exception as e:  # whatever it is, the test shall say so
                    self.bad.append(f"{e!r}: {data[:60].hex()}")
                self.lock.notify_all()

    def _take(self, data, address):
        assert data.startswith(PREAMBLE) and len(data) <= MOST_BYTES, "no datagram of a teller"
        message = fields(data[len(PREAMBLE) :])
        origin = fields(message[1][0])
        process = number(origin, 1)
        teller = self.tellers.setdefault(process, Teller(process, address))
        for field, kind in KINDS.items():
            if field in message:
                teller.take(origin, kind, fields(message[field][0]))

    def wait_until(self, condition, patience=30.0):
        """What the condition gives, once that is true."""
        deadline = time.monotonic() + patience
        with self.lock:
            while True:
                if self.bad:
                    raise AssertionError(f"what was told is not well formed: {self.bad[:3]}")
                found = condition()
                if found:
                    return found
                left = deadline - time.monotonic()
                if left <= 0:
                    raise AssertionError(f"did not happen within {patience} s: told were "
                                         f"{[t.count for t in self.tellers.values()]}")  # fmt: skip
                self.lock.wait(min(left, 0.2))

    def slot(self, slot, frames=1):
        """The teller in that slot, once it has told as many frames and a hello of the session it is in.

        A hello from before it was in knows no number of slots, and the next may come after the first frame.
        """
        return self.wait_until(
            lambda: next(
                (t for t in self.tellers.values()
                 if t.slot == slot and t.hello and number(t.hello, 5) and len(t.frames) >= frames),
                None,
            )
        )  # fmt: skip

    def order(self, teller, field, what, **altered):
        """Gives an order; its number. `altered`: other values of process, token, issuer or number than right ones."""
        self.order_number += 1
        values = {"process": teller.process, "token": teller.token, "issuer": self.issuer, "number": self.order_number}
        values.update(altered)
        message = b"".join(put(i + 1, ("fixed64", values[k])) for i, k in enumerate(("process", "token", "issuer")))
        message += put(4, values["number"]) + put(field, what)
        self.socket.sendto(PREAMBLE + put(8, message), teller.address)
        return values["number"]

    def drive(self, teller, kind, x=0.0, y=0.0, **altered):
        return self.order(teller, 5, put(1, kind) + put(2, float(x)) + put(3, float(y)), **altered)

    def knob(self, teller, name, value):
        return self.order(teller, 6, put(1, name) + put(2, value))

    def netem(self, teller, to, spec):
        return self.order(teller, 7, put(1, to) + put(2, spec))

    def cut(self, teller, peer, seconds):
        return self.order(teller, 8, put(1, peer) + put(2, float(seconds)))

    def pause(self, teller, seconds):
        return self.order(teller, 9, put(1, float(seconds)))

    def push(self, teller, body, x, y):
        return self.order(teller, 10, put(1, body) + put(2, float(x)) + put(3, float(y)))

    def answer(self, teller, order):
        """The first event that answers it."""
        return self.wait_until(lambda: teller.answers(order))[0]

    def close(self):
        self.ending = True
        self.thread.join()
        self.socket.close()
