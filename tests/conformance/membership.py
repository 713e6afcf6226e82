"""Who is there: section 9."""
from protobuf import Single, message, one_of
from rules import ascends, require, require_place
from updates import MOST_PEERS, MOST_TICK, UPDATE_FIELDS, decode_update

MOST_PIECES, MOST_PIECE = 2048, 1150
MOST_HEARD = 0x3FFF
MOST_POLL_NUMBER = 0x3FFF
MOST_DELAY = 0x3FFF
MOST_OWN_ADDRESSES = 4

SEAT_FIELDS = {1: ("slot", "uint32"), 2: ("incarnation", "uint32"), 3: ("have", "uint32"), 4: ("heard", "uint32")}
TOLD_FIELDS = {2: ("mark_tick", "uint32"), 3: ("mark_count", "uint32"), 9: ("update", UPDATE_FIELDS)}
MEMBERSHIP_MESSAGES = {
    1: ("pull", {1: ("nonce", "fixed64"), 2: ("from", "uint32"), 3: ("wanted", "fixed64"),
                  4: ("cookie", "fixed64")}),
    2: ("piece", {1: ("nonce", "fixed64"), 2: ("index", "uint32"), 3: ("count", "uint32"), 4: ("bytes", "bytes")}),
    3: ("enter", {1: ("nonce", "fixed64")}),
    4: ("poll", {1: ("lost", SEAT_FIELDS), 2: ("freeze", "bool"), 3: ("number", "uint32")}),
    5: ("answer", {1: ("lost", SEAT_FIELDS), 2: ("frozen", "bool"), 3: ("tick", "uint32"), 4: ("number", "uint32")}),
    6: ("fetch", {1: ("slot", "uint32"), 2: ("incarnation", "uint32"), 3: ("from", "uint32")}),
    7: ("fetched", {1: ("slot", "uint32"), 2: ("incarnation", "uint32"), 3: ("updates", Single(TOLD_FIELDS))}),
    8: ("probe", {1: ("incarnation", "uint32"), 2: ("member", SEAT_FIELDS), 3: ("knows_you", "bool"), 4: ("newest", "uint32"), 5: ("yields", "bool")}),
    9: ("reach", {1: ("tick", "uint32"), 2: ("heard", {1: ("slot", "uint32"), 2: ("delay", "uint32"), 3: ("carried", "bool")}),
                  3: ("at", {1: ("address", "bytes"), 2: ("port", "uint32")})}),
    10: ("newcomer", {1: ("address", "bytes"), 2: ("port", "uint32")}),
}


def decode_membership(payload):
    """(name, fields) of the message."""
    name, out = one_of(payload, MEMBERSHIP_MESSAGES)
    require(out.get("nonce") != 0, "no nonce")
    require(out.get("slot", 0) < MOST_PEERS, "a slot that is none")
    for column, most in (("lost", MOST_PEERS - 2), ("member", MOST_PEERS)):
        if column in out:
            check_seats(out[column], most)
    if name == "reach":
        slots = [way["slot"] for way in out["heard"]]
        require(len(slots) <= MOST_PEERS and all(slot < MOST_PEERS for slot in slots) and ascends(slots), "ways that are none")
        require(all(way["delay"] <= MOST_DELAY for way in out["heard"]), "a delay that is none")
        check_own_addresses(out["at"])
    if name == "newcomer":
        require_place(out)
    require(out.get("tick", 0) <= MOST_TICK + 1, "a tick that is none")
    require(out.get("number", 0) <= MOST_POLL_NUMBER, "a number that is none")
    if name == "pull":
        require(out["from"] < MOST_PIECES, "from beyond the last piece")
        require(out["cookie"] != 0, "no cookie")
    elif name == "piece":
        require(out["index"] < out["count"] <= MOST_PIECES, "a piece that is none")
        require(1 <= len(out["bytes"]) <= MOST_PIECE, "a piece of another size")
    elif name == "fetched":
        out["update"] = decode_fetched(out.pop("updates") or message(b"", TOLD_FIELDS))
    return name, out


def check_own_addresses(places):
    require(len(places) <= MOST_OWN_ADDRESSES, "too many addresses")
    for place in places:
        require_place(place)
        require(len(place["address"]) == 16, "a key with an own address")


def check_seats(seats, most):
    require(1 <= len(seats) <= most, "nobody, or too many")
    require(all(seat["slot"] < MOST_PEERS for seat in seats), "a slot that is none")
    require(ascends([seat["slot"] for seat in seats]), "seats do not ascend")
    require(all(seat["heard"] <= MOST_HEARD for seat in seats), "heard too long ago")


def decode_fetched(state):
    require(state["mark_tick"] <= MOST_TICK and state["update"], "nothing fetched")
    updates = [decode_update(update, state["mark_tick"], state["mark_count"]) for update in state["update"]]
    require(ascends([update["index"] for update in updates]), "numbers do not ascend")
    require(ascends([update["tick"] for update in updates]), "ticks do not ascend")
    return updates
