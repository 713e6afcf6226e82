"""Protobuf as far as section 2 of the standard goes: from bytes to raw fields by number."""
import struct


class Malformed(Exception):
    """Not a sequence of fields, or a field that is not what its table says."""


VARINT, EIGHT, BYTES, GROUP, END_OF_GROUP, FOUR = 0, 1, 2, 3, 4, 5


def varint(data, at, longest=10):
    """The varint at an offset, and the offset behind it."""
    value = 0
    for n in range(longest):
        if at >= len(data):
            raise Malformed("a varint is cut off")
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << (7 * n)
        if byte < 0x80:
            return value, at
    raise Malformed("a varint is too long")


def take(data, at, count):
    if at + count > len(data):
        raise Malformed("a field is cut off")
    return data[at:at + count], at + count


def fields(data):
    """All (number, wire type, value) of a message: an int for varints, bytes for everything else. Groups are left out."""
    at, groups = 0, []
    while at < len(data):
        key, at = varint(data, at, 5)
        number, wire = (key & 0xFFFFFFFF) >> 3, key & 7
        if number == 0:
            raise Malformed("a field has number 0")
        if wire == GROUP:
            groups.append(number)
            continue
        if wire == END_OF_GROUP:
            if not groups or groups.pop() != number:
                raise Malformed("the end of a group that has not begun")
            continue
        if wire == VARINT:
            value, at = varint(data, at)
        elif wire == BYTES:
            length, at = varint(data, at, 5)
            value, at = take(data, at, length)
        elif wire in (EIGHT, FOUR):
            value, at = take(data, at, 8 if wire == EIGHT else 4)
        else:
            raise Malformed(f"wire type {wire}")
        if not groups:
            yield number, wire, value
    if groups:
        raise Malformed("a group without an end")


def uint32(value):
    """Of a longer number the lower 32 bits count."""
    return value & 0xFFFFFFFF


def zigzag32(value):
    value = uint32(value)
    return value >> 1 if value % 2 == 0 else -((value + 1) >> 1)


def uint32_column(data):
    values, at = [], 0
    while at < len(data):
        value, at = varint(data, at)
        values.append(uint32(value))
    return values


def sint32_column(data):
    values, at = [], 0
    while at < len(data):
        value, at = varint(data, at)
        values.append(zigzag32(value))
    return values


def float_column(data):
    if len(data) % 4:
        raise Malformed("a column of floats is not whole")
    return list(struct.unpack(f"<{len(data) // 4}f", data))


def fixed32_column(data):
    if len(data) % 4:
        raise Malformed("a column of fixed32 is not whole")
    return list(struct.unpack(f"<{len(data) // 4}I", data))


def fixed64_column(data):
    if len(data) % 8:
        raise Malformed("a column of fixed64 is not whole")
    return list(struct.unpack(f"<{len(data) // 8}Q", data))


def text(data):
    """Texts are one line of ASCII; what is not is read as question marks."""
    return "".join(chr(byte) if 0x20 <= byte < 0x7F else "?" for byte in data)


# Type of a field: its wire type, what makes a value of it, and the value when it is absent.
TYPES = {
    "uint32": (VARINT, uint32, 0),
    "sint32": (VARINT, zigzag32, 0),
    "bool": (VARINT, bool, False),
    "fixed32": (FOUR, lambda raw: struct.unpack("<I", raw)[0], 0),
    "fixed64": (EIGHT, lambda raw: struct.unpack("<Q", raw)[0], 0),
    "sfixed64": (EIGHT, lambda raw: struct.unpack("<q", raw)[0], 0),
    "bytes": (BYTES, bytes, b""),
    "text": (BYTES, text, ""),
    "uint32 column": (BYTES, uint32_column, ()),
    "sint32 column": (BYTES, sint32_column, ()),
    "float column": (BYTES, float_column, ()),
    "fixed32 column": (BYTES, fixed32_column, ()),
    "fixed64 column": (BYTES, fixed64_column, ()),
}

# The wire type of a column's value that is not packed, and what makes a number of it.
COLUMNS = {
    "uint32 column": (VARINT, uint32),
    "sint32 column": (VARINT, zigzag32),
    "float column": (FOUR, lambda raw: struct.unpack("<f", raw)[0]),
    "fixed32 column": (FOUR, lambda raw: struct.unpack("<I", raw)[0]),
    "fixed64 column": (EIGHT, lambda raw: struct.unpack("<Q", raw)[0]),
}

# Messages within messages; more than any that is well formed has.
DEEPEST = 100


class Single:
    """The type of a field that is one message: None if absent."""

    def __init__(self, table):
        self.table = table


def default(kind):
    if isinstance(kind, Single):
        return None
    return [] if isinstance(kind, dict) else TYPES[kind][2]


def message(data, table, merged_into=None, depth=0):
    """A message by its table {number: (name, type)}; a type that is itself a table is a repeated message.

    As every protobuf library has it: what is not in the table, or of another wire type than there, is skipped; of a single
    number that comes twice the last counts, single messages are taken together; a column may come in parts, and without
    packing.
    """
    if depth > DEEPEST:
        raise Malformed("too many messages within messages")
    out = merged_into or {name: default(kind) for name, kind in table.values()}
    for number, wire, value in fields(data):
        if number not in table:
            continue
        name, kind = table[number]
        if isinstance(kind, dict):
            out[name] += [message(value, kind, depth=depth + 1)] if wire == BYTES else []
        elif isinstance(kind, Single):
            out[name] = message(value, kind.table, out[name], depth + 1) if wire == BYTES else out[name]
        elif wire == TYPES[kind][0]:
            parsed = TYPES[kind][1](value)
            out[name] = [*out[name], *parsed] if kind in COLUMNS else parsed
        elif kind in COLUMNS and wire == COLUMNS[kind][0]:
            out[name] = [*out[name], COLUMNS[kind][1](value)]
    return out


def one_of(data, messages):
    """(name, fields) of the message that a payload is: of several the last, with those like it that come right before."""
    last, out = None, None
    for number, wire, value in fields(data):
        if number not in messages or wire != BYTES:
            continue
        out = message(value, messages[number][1], out if number == last else None)
        last = number
    if last is None:
        raise Malformed("no message")
    return messages[last][0], out
