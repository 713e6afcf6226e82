"""Rules that the decoder of updates and the decoder of messages share."""
import math

from protobuf import Malformed


class Drop(Exception):
    """The datagram is dropped; reason is one word of the standard's, detail is for people."""

    def __init__(self, reason, detail=""):
        super().__init__(f"{reason}: {detail}" if detail else reason)
        self.reason = reason


def require(condition, detail):
    if not condition:
        raise Malformed(detail)


def require_value(condition, detail):
    if not condition:
        raise Drop("value", detail)


def ascends(values):
    return all(a < b for a, b in zip(values, values[1:]))


def is_address(raw):
    """16 bytes, and in a session with a key 32 more: who is there. Neither is all zeros."""
    return len(raw) in (16, 48) and any(raw[:16]) and (len(raw) == 16 or any(raw[16:]))


def require_place(message):
    """An address and a port that can be sent to."""
    require(is_address(message["address"]), "an address that is none")
    require(1 <= message["port"] <= 65535, "a port that is none")


def check_floats(values, most):
    require_value(all(math.isfinite(value) and abs(value) <= most for value in values), f"{values}")


def check_length(vector, most):
    check_floats(vector, math.inf)
    require_value(math.hypot(*vector) <= most, f"{vector} is longer than {most}")
