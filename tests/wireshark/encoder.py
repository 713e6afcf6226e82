"""As much of an encoder as the tests' hand-written datagrams need."""
import struct
import zlib

STATE, SESSION, MEMBERSHIP = 0, 1, 2


def varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def number(field, value):
    return varint(field << 3) + varint(value) if value else b""


def fixed32(field, value):
    return varint(field << 3 | 5) + struct.pack("<I", value) if value else b""


def block(field, data):
    return varint(field << 3 | 2) + varint(len(data)) + data


def floats(field, *values):
    return block(field, struct.pack(f"<{len(values)}f", *values))


def column(field, values):
    return block(field, b"".join(map(varint, values)))


def tagged(head):
    return head + struct.pack("<I", zlib.crc32(head))


def datagram(kind, payload, peer=0, session=7):
    return tagged(b"Pd" + bytes([0x50 | kind, peer]) + struct.pack("<H", session) + payload)
