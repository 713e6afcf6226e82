"""Joining: section 7."""
from protobuf import one_of
from rules import is_address, require, require_place

KNOWN_FIELDS = {1: ("address", "bytes"), 2: ("port", "uint32"), 3: ("in", "fixed32 column"), 4: ("seeks", "fixed32 column")}
SESSION_MESSAGES = {
    1: ("join", {1: ("nonce", "fixed64"), 2: ("scene_hash", "fixed64"), 3: ("fingerprint", "fixed64"),
                 4: ("authority", "bool"), 5: ("scenario", "text"), 6: ("padding", "bytes"), 7: ("spectator", "bool")}),
    2: ("welcome", {1: ("nonce", "fixed64"), 2: ("peer", "uint32"), 3: ("slots", "uint32"), 4: ("wanted", "uint32"),
                    6: ("incarnation", "uint32"), 7: ("cookie", "fixed64"), 8: ("session", "bytes")}),
    3: ("redirect", {1: ("nonce", "fixed64"), 2: ("address", "bytes"), 3: ("port", "uint32")}),
    4: ("refuse", {1: ("nonce", "fixed64"), 2: ("reason", "text")}),
    5: ("ping", {1: ("sent_us", "sfixed64"), 2: ("padding", "bytes")}),
    6: ("pong", {1: ("sent_us", "sfixed64"), 2: ("session_us", "sfixed64")}),
    10: ("ask", {1: ("nonce", "fixed64"), 2: ("crowd", "fixed64"), 3: ("about", "fixed32"), 4: ("in", "fixed32 column"),
                 5: ("seeks", "fixed32 column"), 6: ("rank", "fixed32"), 7: ("padding", "bytes")}),
    11: ("tell", {1: ("nonce", "fixed64"), 2: ("crowd", "fixed64"), 3: ("about", "fixed32"), 4: ("in", "fixed32 column"),
                  5: ("seeks", "fixed32 column"), 6: ("rank", "fixed32"), 7: ("clock_us", "sfixed64"),
                  8: ("known", KNOWN_FIELDS), 9: ("noted", "bool")}),
}
RANGES = {  # of fields of session messages, by name; others take anything
    "slots": (1, 64), "wanted": (1, 64), "port": (1, 65535), 
    "sent_us": (-(1 << 53), 1 << 53), "session_us": (-(1 << 53), 1 << 53),
}
MOST_REGIONS, MOST_KNOWN, MOST_CLOCK = 8, 16, 1 << 53
MOST_REASON, MOST_LABEL, LEAST_PING_PADDING = 400, 128, 18


def decode_session(payload):
    """(name, fields) of the message."""
    name, out = one_of(payload, SESSION_MESSAGES)
    check_ranges(out)
    check_session(name, out)
    return name, out


def check_ranges(content):
    for field, (least, most) in RANGES.items():
        require(least <= content.get(field, least) <= most, f"{field} is {content.get(field)}")
    require(len(content.get("reason", "")) <= MOST_REASON, "a long reason")
    require(len(content.get("scenario", "")) <= MOST_LABEL, "a long label")
    require("address" not in content or is_address(content["address"]), "an address that is none")


def check_regions(content):
    """Of whoever says where it is, or is said to be somewhere: section 15."""
    for regions in (content["in"], content["seeks"]):
        require(len(regions) <= MOST_REGIONS and 0 not in regions, "too many regions, or one that is none")


def check_finding(name, content):
    require(content["nonce"] != 0 and content["about"] != 0, "about nothing")
    check_regions(content)
    if name == "tell":
        require(0 <= content["clock_us"] <= MOST_CLOCK, "a clock that is none")
        require(len(content["known"]) <= MOST_KNOWN, "knows too many")
        for known in content["known"]:
            require_place(known)
            require(len(known["address"]) == 16, "a key in a crowd")
            check_regions(known)


def check_session(name, content):
    """What is particular to one message."""
    if name == "join":
        require(content["nonce"] != 0, "a join without a nonce")
    elif name == "welcome":
        require(content["wanted"] <= content["slots"], "waits for more than may come")
        require(content["peer"] < content["slots"], "a number that is none")
        require(content["incarnation"] > 0 and content["cookie"] > 0, "no incarnation, or no cookie")
        require(not content["session"] or (len(content["session"]) == 16 and any(content["session"])), "no session's id")
    elif name in ("ask", "tell"):
        check_finding(name, content)
    elif name == "ping":
        require(len(content["padding"]) >= LEAST_PING_PADDING, "a ping smaller than its pong")
