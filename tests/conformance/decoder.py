"""A second decoder of the protocol, written from proto/WIRE.md alone: it shares no code and no schema with the peers.

decode(datagram) gives the datagram as a dict, or raises Drop with the reason for which the standard has it dropped. What
depends on a session (members, clocks, the scenario, what came before) is not known here; everything else is checked.
"""
import struct
import zlib

from membership import decode_membership
from protobuf import Malformed, message
from rules import Drop, require
from session_messages import decode_session
from updates import UPDATE_FIELDS, check_values, decode_update

HEADER, TAG, LARGEST = 6, 4, 1200
VERSION = 9
STATE, SESSION, MEMBERSHIP = 0, 1, 2

STATE_FIELDS = {
    1: ("link", "uint32 column"), 8: ("transit", "sint32"), 9: ("update", UPDATE_FIELDS), 10: ("check_age", "uint32"),
    11: ("check_hash", "fixed32"), 12: ("loss", "uint32"),
}
LINK = ("seq", "mark_tick", "mark_count", "have", "seen_seq", "seen_age", "have_beyond", "incarnation", "to_incarnation")


def decode(datagram):
    kind = check_envelope(datagram)
    out = {"kind": kind, "sender": datagram[3], "session": struct.unpack_from("<H", datagram, 4)[0]}
    payload = datagram[HEADER:-TAG]
    try:
        if kind == STATE:
            out.update(decode_state(payload, out["sender"]))
        elif kind == SESSION:
            out["message"] = decode_session(payload)
        else:
            out["message"] = decode_membership(payload)
    except Malformed as error:
        raise Drop("malformed", str(error)) from None
    return out


def check_envelope(datagram):
    """Section 1, in its order; gives the kind."""
    if len(datagram) < HEADER + TAG:
        raise Drop("short")
    if len(datagram) > LARGEST:
        raise Drop("long")
    if datagram[:2] != b"Pd":
        raise Drop("magic")
    if zlib.crc32(datagram[:-TAG]) != struct.unpack("<I", datagram[-TAG:])[0]:
        raise Drop("tag")
    if datagram[2] >> 4 != VERSION:
        raise Drop("version")
    kind = datagram[2] & 15
    if kind not in (STATE, SESSION, MEMBERSHIP):
        raise Drop("kind")
    return kind


def decode_state(payload, sender):
    raw = message(payload, STATE_FIELDS)
    link = raw.pop("link")
    require(len(link) <= len(LINK), "too many numbers of the link")
    raw.update(zip(LINK, [*link, *[0] * (len(LINK) - len(link))]))
    require(raw["seq"] > 0, "seq 0")
    require(raw["mark_tick"] < (1 << 31) - 1, "mark_tick beyond the last")
    require(raw["loss"] <= 100, "loss above 100 per cent")
    require(raw["check_age"] <= raw["mark_tick"], "a hash of before the start")
    raw["updates"] = [decode_update(update, raw["mark_tick"], raw["mark_count"]) for update in raw.pop("update")]
    # Only now: what is malformed anywhere comes first.
    for n, update in enumerate(raw["updates"]):
        before = raw["updates"][n - 1]
        if n > 0 and (update["index"] <= before["index"] or update["tick"] <= before["tick"]):
            raise Drop("order", "updates do not ascend")
        check_values(update, sender)
    raw["check_tick"] = raw["mark_tick"] - raw.pop("check_age")
    return raw
