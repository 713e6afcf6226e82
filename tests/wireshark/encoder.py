"""As much of an encoder as the tests' hand-written datagrams need."""
import struct
import zlib

STATE, SESSION, MEMBERSHIP = 0, 1, 2
PLACE, MOTION = 1 / (1 << 14), 1 / (1 << 12)  # steps of values
MOST_STEPS = (1 << 24) - 1


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


def in_steps(numbers):
    return block(6, b"".join(varint(2 * n if n >= 0 else -2 * n - 1) for n in numbers))


def values(*told):
    """Of an update, each (value, step), as section 3 has them: in steps if all can be told so."""
    numbers = [struct.unpack("<f", struct.pack("<f", value))[0] / step for value, step in told]
    if all(abs(n) <= MOST_STEPS and n.is_integer() for n in numbers):
        return in_steps(map(int, numbers))
    return floats(5, *(value for value, _ in told))


def tagged(head):
    return head + struct.pack("<I", zlib.crc32(head))


def datagram(kind, payload, peer=0, session=7):
    return tagged(b"Pd" + bytes([0x90 | kind, peer]) + struct.pack("<H", session) + payload)
