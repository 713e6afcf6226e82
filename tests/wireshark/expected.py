"""A datagram as the second decoder (tests/conformance) reads it: the list of (field, value) that Wireshark must show.

Depth first and in the order of the datagram; nodes, which only group, stand in it with the value None. What hangs on other
datagrams is not in it.
"""
import struct
import zlib

from decoder import STATE_FIELDS, decode
from membership import MEMBERSHIP_MESSAGES
from protobuf import message, one_of
from rules import Drop
from transfer import TRANSFER_FIELDS
from updates import CAUSES, MODELS, UPDATE_FIELDS, decode_update

KINDS = ("state", "session", "membership")
NOBODY = 255
SEALED = (0x94, 0x95, 0x96, 0x98, 0x99, 0x9A)
HANDSHAKES = ("hello", "cookie", "introduction", "acceptance", "rekey")


def is_claimed(datagram):
    """Whether it is to be taken for one of ours: the magic, and the right tag or a header as ours are."""
    if datagram[:2] != b"Pd" or len(datagram) < 6:
        return False
    good = len(datagram) >= 10 and zlib.crc32(datagram[:-4]) == struct.unpack("<I", datagram[-4:])[0]
    ours = datagram[2] in (0x90, 0x91, 0x92) and (datagram[3] < 64 or datagram[3] == NOBODY)
    return good or ours or is_handshake(datagram) or is_sealed(datagram) and (datagram[3] < 64 or datagram[3] == NOBODY)


def has_crc(datagram):
    return zlib.crc32(datagram[:-4]) == struct.unpack("<I", datagram[-4:])[0]


def is_sealed(datagram):
    kind = datagram[2] if len(datagram) >= 30 else 0
    return datagram[:2] == b"Pd" and len(datagram) <= 1220 and kind in SEALED and not has_crc(datagram)


def is_handshake(datagram):
    return len(datagram) == 76 and datagram[:3] == b"Pd\x93" and 1 <= datagram[3] <= 5 and not has_crc(datagram)


def fields(datagram, opened=None):
    """`opened`: what a key log tells of a sealed one: the unsealed datagram, or False if its tag is wrong."""
    return list(of_datagram(datagram, opened))


def of_datagram(datagram, opened):
    yield "padr.version", datagram[2] >> 4
    if is_handshake(datagram):
        yield "padr.handshake", HANDSHAKES[datagram[3] - 1]
        yield "padr.handshake.key", datagram[4:36]
        yield "padr.handshake.number", datagram[36:44]
        if datagram[3] == 5:
            yield from zip(("padr.seal.id", "padr.handshake.generation"), struct.unpack("<II", datagram[44:52]))
            yield "padr.handshake.has", datagram[52:60]
        else:
            yield "padr.handshake.cookie", datagram[44:60]
        yield "padr.seal.tag", datagram[60:76]
        return
    if is_sealed(datagram):
        yield from of_sealed(datagram, opened)
        return
    yield "padr.kind", datagram[2] & 15
    yield "padr.peer", datagram[3]
    yield "padr.session", struct.unpack_from("<H", datagram, 4)[0]
    if len(datagram) >= 10:
        tag = struct.unpack("<I", datagram[-4:])[0]
        yield "padr.tag", tag
        yield "padr.tag_good", tag == zlib.crc32(datagram[:-4])
    yield from of_content(datagram)


def of_sealed(datagram, opened):
    yield "padr.kind", datagram[2] & 3
    yield "padr.peer", datagram[3]
    yield "padr.session", struct.unpack_from("<H", datagram, 4)[0]
    yield "padr.seal", ("auth", "encrypt")[(datagram[2] >> 2 & 3) - 1]
    yield "padr.seal.id", struct.unpack_from("<I", datagram, 6)[0]
    yield "padr.seal.number", struct.unpack_from("<I", datagram, 10)[0]
    yield "padr.seal.tag", datagram[-16:]
    if opened is not None:
        yield "padr.seal.good", bool(opened)
        if opened:
            yield from of_content(opened)
    elif datagram[2] < 0x98:
        plain = datagram[:2] + bytes([datagram[2] & 0xF3]) + datagram[3:6] + datagram[14:-16]
        yield from of_content(plain + struct.pack("<I", zlib.crc32(plain)))


def of_content(datagram):
    try:
        decoded = decode(datagram)
    except Drop as drop:
        yield "padr.drop", drop.reason
        return
    yield from of_state(datagram, decoded) if decoded["kind"] == 0 else of_message(datagram, decoded)


def of_state(datagram, decoded):
    raw = message(datagram[6:-4], STATE_FIELDS)
    yield "padr.seq", decoded["seq"]
    yield "padr.tick", decoded["mark_tick"]
    for name in ("mark_count", "have", "have_beyond", "seen_seq", "seen_age", "transit", "loss", "incarnation", "to_incarnation"):
        yield f"padr.{name}", decoded[name]
    if decoded["check_hash"]:
        yield "padr.check_age", raw["check_age"]
        yield "padr.check_tick", decoded["check_tick"]
        yield "padr.check_hash", decoded["check_hash"]
    yield "padr.mark", not decoded["updates"]
    yield "padr.updates", len(decoded["updates"])
    yield "padr.bodies", sum(bodies_in(update) for update in decoded["updates"])
    for update, sent in zip(decoded["updates"], raw["update"]):
        yield from of_update(update, sent, decoded["sender"])


def bodies_in(update):
    return len(update["bodies"]) + (bodies_in(update["passed_on"]) if update["passed_on"] else 0)


def of_update(update, raw, peer):
    """`raw` is the message as sent, where there is what the decoder has worked out already."""
    yield "padr.update", None
    yield "padr.update.index_back", raw["index_back"]
    yield "padr.update.tick_back", raw["tick_back"]
    yield "padr.update.peer", peer
    yield "padr.update.index", update["index"]
    yield "padr.update.tick", update["tick"]
    if update["leave"]:
        yield "padr.update.leave", True
    if raw["spectates"]:
        yield "padr.update.spectates", True
    if raw["going"]:
        yield "padr.update.going", raw["going"]
    if raw.get("signature"):
        yield "padr.update.signature", raw["signature"]
    if update["avatar"]:
        yield from of_avatar(update["avatar"], raw["avatar"])
    for body in update["bodies"]:
        yield from of_body(body, peer)
    yield from of_orders(update, raw)


def of_avatar(avatar, flags):
    yield "padr.avatar", None
    yield "padr.avatar.flags", flags
    yield "padr.cause", CAUSES.index(avatar["cause"])
    yield "padr.avatar.model", MODELS.index(avatar["model"])
    yield "padr.avatar.awake", avatar["awake"]
    yield from vector("padr.avatar", ("x", "y"), avatar["position"])
    yield from vector("padr.avatar", ("vx", "vy"), avatar["velocity"])
    yield from vector("padr.avatar", ("control_x", "control_y"), avatar["control"] or ())


def vector(prefix, names, values):
    for name, value in zip(names, values):
        yield f"{prefix}.{name}", value


def of_body(body, peer):
    state = body["state"]
    yield "padr.body", None
    yield "padr.entity", body["id"]
    yield "padr.body.flags", body["flags"]
    yield "padr.cause", CAUSES.index(body["cause"])
    yield "padr.hold", body["held"]
    yield "padr.release", body["release"]
    yield "padr.body.state", state is not None
    if state is None:
        return
    yield "padr.owner", NOBODY if body["release"] else peer
    yield "padr.epoch", state["epoch"]
    yield "padr.claim_age", state["claim_age"]
    yield "padr.claimed", state["claimed"]
    yield "padr.body.awake", state["awake"]
    yield from vector("padr.body", ("x", "y"), state["position"])
    yield "padr.body.angle", state["angle"]
    if state["awake"]:
        yield from vector("padr.body", ("vx", "vy"), state["velocity"])
        yield "padr.body.spin", state["spin"]


def of_orders(update, raw):
    admission, passed_on = update["admission"], update["passed_on"]
    if admission:
        yield "padr.admission", None
        for name in ("slot", "incarnation", "first", "address", "port"):
            yield f"padr.admission.{name}", admission[name]
        for have in admission["have"]:
            yield "padr.admission.have", have
        yield "padr.admission.spectator", admission["spectator"]
    for removal in update["removals"]:
        yield "padr.removal", None
        for name in ("slot", "incarnation", "count"):
            yield f"padr.removal.{name}", removal[name]
    for passage in raw["passages"]:
        yield "padr.passage", None
        for name in ("region", "number", "crossings", "flags"):
            yield f"padr.passage.{name}", passage[name]
        for value in passage["state"]:
            yield "padr.passage.state", value
        yield "padr.passage.to", passage["to"]
    if passed_on:
        sent = raw["passed_on"]
        yield "padr.passed_on", None
        for name in ("slot", "index", "tick"):
            yield f"padr.passed_on.{name}", sent[name]
        yield from of_update(passed_on, sent["update"] or message(b"", UPDATE_FIELDS), passed_on["slot"])


# Nodes of messages, as the decoder calls them: their own name, and the names of what is in them.
NODES = {
    ("poll", "lost"): ("lost", ("slot", "incarnation", "have", "heard")),
    ("answer", "lost"): ("lost", ("slot", "incarnation", "have", "heard")),
    ("probe", "member"): ("members", ("slot", "incarnation", "have", "heard")),
    ("reach", "heard"): ("heard", ("slot", "delay", "carried")),
    ("reach", "at"): ("at", ("address", "port")),
    ("tell", "known"): ("known", ("address", "port", "in", "seeks")),
}


def of_message(datagram, decoded):
    name, content = decoded["message"]
    yield "padr.message", name
    for field, value in content.items():
        if (name, field) in NODES:
            node, parts = NODES[name, field]
            for each in value:
                yield f"padr.{name}.{node}", None
                for part in parts:
                    values = each[part] if isinstance(each[part], (list, tuple)) else [each[part]]
                    yield from ((f"padr.{name}.{node}.{part}", value) for value in values if value != b"")
        elif isinstance(value, (list, tuple)) and field in ("in", "seeks"):
            yield from ((f"padr.{name}.{field}", each) for each in value)
        elif field == "nonce":
            yield "padr.nonce", value
        elif field == "padding":
            yield f"padr.{name}.padding", len(value)
        elif field != "update":
            yield f"padr.{name}.{field}", value
    if name == "fetched":
        yield from of_fetched(datagram, content)


def of_fetched(datagram, content):
    raw = one_of(datagram[6:-4], MEMBERSHIP_MESSAGES)[1]["updates"]
    yield "padr.fetched.mark_tick", raw["mark_tick"]
    yield "padr.fetched.mark_count", raw["mark_count"]
    for update, sent in zip(content["update"], raw["update"]):
        yield from of_update(update, sent, content["slot"])


ENTITY = ("x", "y", "angle", "vx", "vy", "spin", "sleep_time")
PARTS = {  # of a transfer: messages and columns, as the decoder calls them, and the names of what is in them
    "contacts": ("contact", ("key", "numbers", "ids", "type", "touching")),
    "avatars": ("avatar", ("present", "incarnation", "member", "model", "numbers", "since", "at_rest")),
    "authority": ("authority", ("owner", "released", "epoch", "claimed")), "holds": ("holds", ()),
    "slots": ("slot", ("first", "have", "address", "port", "since")),
    "gone": ("gone", ("address", "port", "since", "removed")),
    "proofs": ("proof", ("key", "incarnation", "one", "other")),
}  # fmt: skip


def of_transfer(data):
    """Of the bytes of all pieces."""
    raw = message(data, TRANSFER_FIELDS)
    yield "padr.transfer", None
    for field in ("tick", "wanted", "begin"):
        yield f"padr.transfer.{field}", raw[field]
    for n, awake in enumerate(raw["awake"]):
        yield "padr.transfer.entity", None
        yield from vector("padr.transfer.entity", ENTITY, raw["entities"][7 * n:7 * n + 7])
        yield "padr.transfer.entity.awake", bool(awake)
    for part, (node, names) in PARTS.items():
        for each in raw[part]:
            yield f"padr.transfer.{node}", None if names else each
            for name in names:
                values = each[name] if isinstance(each[name], (list, tuple)) else [each[name]]
                yield from ((f"padr.transfer.{node}.{name}", value) for value in values if value != b"")
    for each in raw["tail"]:
        yield "padr.transfer.tail", None
        yield from vector("padr.transfer.tail", ("slot", "index", "tick"), (each["slot"], each["index"], each["tick"]))
        sent = each["update"] or message(b"", UPDATE_FIELDS)
        yield from of_update(decode_update(sent, each["tick"], each["index"] + 1), sent, each["slot"])
