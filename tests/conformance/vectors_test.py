"""The second decoder reads the standard's test vectors as the standard says, and drops every damaged version of them."""
import re
import struct
import sys
import zlib
from collections import Counter

from decoder import VERSION, decode
from listing import listing
from rules import Drop

MOST_MUTATED = 128  # bytes of a datagram: one is mostly padding
VECTOR = re.compile(r"```(?:hex|bytes)\n([^`]*)```\s+```(?:fields|reading)\n([^`]*)```")
ANNOTATED = re.compile(r"```annotated\n([^`]*)```")


def vectors(paths):
    text = ""
    for path in paths:
        with open(path, encoding="utf-8") as file:
            text += file.read()
    found = [(from_hex(hex), fields.splitlines()) for hex, fields in VECTOR.findall(text)]
    assert len(found) >= 20 and len(found) == len(re.findall(r"^```(?:hex|bytes)$", text, re.M)), f"{len(found)} test vectors"
    for hex in ANNOTATED.findall(text):
        assert from_hex(hex) in [datagram for datagram, _ in found], "an annotated datagram that is no vector"
    return found


def from_hex(text):
    """Bytes in hexadecimal, with comments behind `#`, and `00*9` for nine bytes 00."""
    text = re.sub(r"#.*", "", text)
    return bytes.fromhex(re.sub(r"(\w\w)\*(\d+)", lambda found: found[1] * int(found[2]), text))


def reason(datagram):
    """Why a datagram is dropped, or None if it is not."""
    try:
        decode(datagram)
    except Drop as drop:
        return drop.reason
    return None


def tagged(head):
    return head + struct.pack("<I", zlib.crc32(head))


def check_damage(datagram):
    """A cut, a flipped bit, a changed byte, something appended: each is found."""
    for length in range(len(datagram)):
        assert reason(datagram[:length]) == ("short" if length < 10 else "tag"), length
    for bit in range(8 * len(datagram)):
        damaged = bytearray(datagram)
        damaged[bit // 8] ^= 1 << bit % 8
        assert reason(bytes(damaged)) == ("magic" if bit < 16 else "tag"), bit
    for at in range(len(datagram)):
        damaged = datagram[:at] + bytes([datagram[at] ^ 0xFF]) + datagram[at + 1:]
        assert reason(damaged) == ("magic" if at < 2 else "tag"), at
    assert reason(datagram + b"\0") == ("tag" if len(datagram) < 1200 else "long")


def check_order_of_reasons(datagram):
    """Of several things wrong, the reason is the one the standard names first."""
    def rebuilt(magic, version_and_kind):
        return tagged(magic + bytes([version_and_kind]) + datagram[3:-4])

    assert reason(b"") == "short"
    assert reason(b"Pd" + bytes(1199)) == "long"
    assert reason(rebuilt(b"Px", VERSION << 4 | 15)) == "magic"
    assert reason(rebuilt(b"Pd", (VERSION + 1) << 4 | 15)) == "version"
    assert reason(rebuilt(b"Pd", VERSION << 4 | 15)) == "kind"


def check_shortened(datagram):
    """A payload cut at any byte under a tag that fits: never anything but a decoded datagram or a named reason."""
    for length in range(6, len(datagram) - 4):
        assert reason(tagged(datagram[:length])) in (None, "malformed"), length


def check_mutated(datagram):
    """Every byte of the payload changed to many others, under a tag that fits: it is read, or dropped for a reason that can be."""
    reasons = Counter()
    for at in range(6, min(len(datagram), MOST_MUTATED) - 4):
        for change in range(1, 256, 3):
            reasons[reason(tagged(datagram[:at] + bytes([datagram[at] ^ change]) + datagram[at + 1:-4]))] += 1
    assert set(reasons) <= {None, "malformed", "order", "value"}, reasons
    return reasons


def main(*paths):
    assert zlib.crc32(b"123456789") == 0xCBF43926
    found = vectors(paths)
    reasons = Counter()
    for datagram, fields in found:
        if fields[0].startswith("drop = "):
            assert f"drop = {reason(datagram)}" == fields[0], (fields, reason(datagram), datagram.hex(" "))
            continue
        lines = [line for line in fields if not line.startswith("canonical = ")]
        assert listing(decode(datagram)) == lines, "\n".join(listing(decode(datagram)))
        check_damage(datagram)
        check_order_of_reasons(datagram)
        check_shortened(datagram)
        reasons += check_mutated(datagram)
    print(f"{len(found)} vectors are as listed; with changed bytes under a fitting tag: {dict(reasons)}")


main(*sys.argv[1:])
