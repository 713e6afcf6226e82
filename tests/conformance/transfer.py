"""The transfer: all that a newcomer needs, section 10."""
import math
from collections import namedtuple

from listing import place, shown, update_lines
from protobuf import message
from rules import ascends, check_floats, check_length, require, require_place, require_value
from updates import (MODELS, MOST_ANGLE, MOST_CONTROL, MOST_EPOCH, MOST_NUMBER, MOST_SPEED, MOST_SPIN, MOST_TICK,
                     PASSED_ON_FIELDS, UPDATE_FIELDS, check_values, decode_update)  # fmt: skip

MOST_GONE, MOST_PROOFS, MOST_NORMAL, MOST_LOCAL, MOST_IMPULSE, MARGIN = 64, 8, 1.01, 1e4, 1e9, 20
START_LEAD = 60

CONTACT_FIELDS = {
    1: ("key", "uint32"), 2: ("numbers", "float column"), 3: ("ids", "fixed32 column"), 4: ("type", "uint32"),
    5: ("touching", "bool"),
}
AVATAR_FIELDS = {
    1: ("present", "bool"), 2: ("incarnation", "uint32"), 3: ("member", "bool"), 4: ("model", "uint32"),
    5: ("numbers", "float column"), 6: ("since", "uint32"), 7: ("at_rest", "bool"), 8: ("going", "bool"),
}
AUTHORITY_FIELDS = {1: ("owner", "uint32"), 2: ("released", "bool"), 3: ("epoch", "uint32"), 4: ("claimed", "uint32")}
SLOT_FIELDS = {1: ("first", "uint32"), 2: ("have", "uint32"), 3: ("address", "bytes"), 4: ("port", "uint32"),
               5: ("since", "uint32")}
RESIDENT_FIELDS = {
    1: ("region", "uint32"), 2: ("number", "uint32"), 3: ("crossings", "uint32"), 4: ("present", "bool"),
    5: ("at", "uint32"), 6: ("bound", "uint32"),
}
PLACE_FIELDS = {1: ("address", "bytes"), 2: ("port", "uint32"), 3: ("since", "uint32"), 4: ("removed", "uint32")}
PROOF_FIELDS = {1: ("key", "bytes"), 2: ("incarnation", "uint32"), 3: ("one", "bytes"), 4: ("other", "bytes")}
TRANSFER_FIELDS = {
    1: ("tick", "uint32"), 2: ("entities", "float column"), 3: ("awake", "bytes"), 4: ("contacts", CONTACT_FIELDS),
    5: ("avatars", AVATAR_FIELDS), 6: ("authority", AUTHORITY_FIELDS), 7: ("holds", "fixed64 column"),
    8: ("slots", SLOT_FIELDS), 9: ("tail", PASSED_ON_FIELDS), 10: ("gone", PLACE_FIELDS),
    11: ("residents", RESIDENT_FIELDS), 12: ("went", RESIDENT_FIELDS),
    13: ("wanted", "uint32"), 14: ("begin", "uint32"), 15: ("proofs", PROOF_FIELDS),
}

# What a transfer is held against: numbers of bodies, slots and fixed things, and the scenario's corners.
Scenario = namedtuple("Scenario", "bodies slots fixed lower_x lower_y upper_x upper_y")


def decode_transfer(data, scenario):
    """The transfer as a dict; Malformed or Drop if it is to be refused."""
    out = message(data, TRANSFER_FIELDS)
    require(out["tick"] <= MOST_TICK, "a tick that is none")
    require(out["wanted"] <= scenario.slots and out["begin"] <= out["tick"] + START_LEAD, "a begin of play that is none")
    require(not out["wanted"] or not out["begin"], "a begin of play, and members that it waits for")
    check_entities(out, scenario)
    check_contacts(out["contacts"], scenario)
    check_avatars(out, scenario)
    check_authority(out, scenario)
    check_slots(out, scenario)
    out["tail"] = decode_tail(out, scenario)
    require(len(out["gone"]) <= MOST_GONE, "too many that are gone")
    require(not out["residents"] and not out["went"], "bodies that come and go, in a session that is no region")
    for gone in out["gone"]:
        require_place(gone)
        require(gone["since"] <= gone["removed"] <= MOST_TICK, "declared gone before it came, or at no tick")
    check_proofs(out, scenario)
    return out


def check_proofs(out, scenario):
    require(len(out["proofs"]) <= MOST_PROOFS, "too many proofs")
    for proof in out["proofs"]:
        require(len(proof["key"]) == 32 and proof["incarnation"] <= MOST_NUMBER, "a proof against nobody")
        for part in ("one", "other"):
            raw = message(proof[part], PASSED_ON_FIELDS)
            require(raw["slot"] < scenario.slots and raw["index"] <= MOST_NUMBER and raw["tick"] <= MOST_TICK, "of nobody")
            update = decode_update(raw["update"] or message(b"", UPDATE_FIELDS), raw["tick"], raw["index"] + 1)
            proof[part] = {"slot": raw["slot"], **update}


def check_place(position, scenario):
    check_floats(position, math.inf)
    x, y = position
    require_value(scenario.lower_x - MARGIN <= x <= scenario.upper_x + MARGIN, "x")
    require_value(scenario.lower_y - MARGIN <= y <= scenario.upper_y + MARGIN, "y")


def check_entities(out, scenario):
    count = scenario.bodies + scenario.slots
    require(len(out["entities"]) == 7 * count and len(out["awake"]) == count, "another number of entities")
    out["entities"] = [tuple(out["entities"][7 * n:7 * n + 7]) for n in range(count)]
    for (x, y, angle, vx, vy, spin, sleep_time), awake in zip(out["entities"], out["awake"]):
        check_place((x, y), scenario)
        check_floats((angle,), MOST_ANGLE)
        check_length((vx, vy), MOST_SPEED)
        check_floats((spin,), MOST_SPIN)
        require_value(math.isfinite(sleep_time) and sleep_time >= 0, "sleep_time")
        require(awake in (0, 1), "neither awake nor asleep")
        require(awake or (vx, vy, spin, sleep_time) == (0, 0, 0, 0), "asleep and not still")


def check_contacts(contacts, scenario):
    require(ascends([contact["key"] for contact in contacts]), "contacts do not ascend")
    moving = scenario.bodies + scenario.slots
    for contact in contacts:
        first, second = contact["key"] >> 16, contact["key"] & 0xFFFF
        require(first < moving and first < second < moving + scenario.fixed, "a contact of no two things")
        points, numbers = len(contact["ids"]), contact["numbers"]
        require(points <= 2 and (points or contact["touching"]), "a contact that is none")
        require(contact["type"] <= 2, "a type that is none")
        require(len(numbers) == 4 + 4 * points, "another number of numbers")
        check_floats(numbers[:2], MOST_NORMAL)
        check_floats(numbers[2:4], MOST_LOCAL)
        for n in range(4, len(numbers), 4):
            check_floats(numbers[n:n + 2], MOST_LOCAL)
            check_floats(numbers[n + 2:n + 4], MOST_IMPULSE)
            require_value(numbers[n + 2] >= 0, "a contact that pulls")


def check_avatars(out, scenario):
    require(len(out["avatars"]) == scenario.slots, "another number of avatars")
    for avatar in out["avatars"]:
        require(len(avatar["numbers"]) == 4, "another number of numbers")
        check_length(avatar["numbers"][:2], MOST_SPEED)
        check_length(avatar["numbers"][2:], MOST_CONTROL)
        require(avatar["model"] < len(MODELS) and avatar["since"] <= out["tick"], "a model that is none")
        require(avatar["member"] or not avatar["present"], "an avatar without a member")
        require(not avatar["going"], "somebody who wants to leave, in a session that is no region")
        require(avatar["incarnation"] <= MOST_NUMBER, "incarnation")


def check_authority(out, scenario):
    require(len(out["authority"]) == len(out["holds"]) == scenario.bodies, "another number of bodies")
    require(all(mask < 1 << scenario.slots for mask in out["holds"]), "held by nobody's avatar")
    for body in out["authority"]:
        require(body["owner"] <= scenario.slots and body["claimed"] <= out["tick"], "a claim that is none")
        require(body["epoch"] <= MOST_EPOCH, "epoch")
        blank = body["released"] and body["epoch"] == 0 and body["claimed"] == 0
        require(body["epoch"] > 0 if body["owner"] else blank, "claimed by nobody, or not at all")


def check_slots(out, scenario):
    require(len(out["slots"]) == scenario.slots, "another number of slots")
    for slot in out["slots"]:
        require(slot["first"] <= slot["have"] <= MOST_NUMBER, "numbers that do not go together")
        if slot["address"]:
            require_place(slot)
        else:
            require(slot["port"] == 0, "a port of no address")
        require(slot["since"] <= MOST_TICK, "let in at no tick")


def decode_tail(out, scenario):
    tail = []
    for raw in out["tail"]:
        require(raw["slot"] < scenario.slots and raw["index"] <= MOST_NUMBER and raw["tick"] <= MOST_TICK, "of nobody")
        update = decode_update(raw["update"] or message(b"", UPDATE_FIELDS), raw["tick"], raw["index"] + 1)
        require(update["tick"] >= out["tick"], "an update that is in the world already")
        check_values(update, raw["slot"])
        check_of_session(update, scenario)
        tail.append({"slot": raw["slot"], **update})
    require(ascends([(update["tick"], update["slot"]) for update in tail]), "the tail does not ascend")
    return tail


def check_of_session(update, scenario):
    """What only who knows the session and the scenario can check of an update."""
    require_value(not update["passages"] and not update["going"], "borders, in a session that is no region")
    admission, passed_on = update["admission"], update["passed_on"]
    if admission:
        require_value(admission["slot"] < scenario.slots and len(admission["have"]) == scenario.slots, "slots")
    require_value(all(removal["slot"] < scenario.slots for removal in update["removals"]), "slots")
    for body in update["bodies"]:
        require_value(body["id"] < scenario.bodies, "no such body")
        if body["state"]:
            check_place(body["state"]["position"], scenario)
    if update["avatar"]:
        check_place(update["avatar"]["position"], scenario)
    if passed_on:
        require_value(passed_on["slot"] < scenario.slots, "slots")
        check_of_session(passed_on, scenario)


def transfer_lines(out):
    """As the listings of test vectors have it."""
    lines = [f"transfer.{field} = {out[field]}" for field in ("tick", "wanted", "begin")]
    for n, (numbers, awake) in enumerate(zip(out["entities"], out["awake"])):
        lines.append(f"transfer.entity[{n}] = {shown(numbers)} {awake}")
    for n, contact in enumerate(out["contacts"]):
        numbers, name = contact["numbers"], f"transfer.contact[{n}]"
        head = (contact["key"], contact["type"], contact["touching"], *numbers[:4])
        lines.append(f"{name} = {shown(head)}")
        for i, point in enumerate(contact["ids"]):
            lines.append(f"{name}.point[{i}] = {shown((*numbers[4 + 4 * i:8 + 4 * i], point))}")
    for n, (avatar, slot) in enumerate(zip(out["avatars"], out["slots"])):
        values = (avatar["present"], avatar["incarnation"], MODELS[avatar["model"]], *avatar["numbers"], avatar["since"],
                  avatar["at_rest"])  # fmt: skip
        lines.append(f"transfer.avatar[{n}] = {shown(values)}")
        where = f" {place(slot)}" if slot["address"] else ""
        lines.append(f"transfer.slot[{n}] = {slot['first']} {slot['have']}{where} {slot['since']}")
    for n, (body, holds) in enumerate(zip(out["authority"], out["holds"])):
        lines.append(f"transfer.body[{n}] = {shown((*body.values(), holds))}")
    for n, update in enumerate(out["tail"]):
        lines += [f"transfer.tail[{n}].slot = {update['slot']}"] + update_lines(f"transfer.tail[{n}]", update)
    lines += [
        f"transfer.gone[{n}] = {place(gone)} {gone['since']} {gone['removed']}" for n, gone in enumerate(out["gone"])]
    for n, proof in enumerate(out["proofs"]):
        lines.append(f"transfer.proof[{n}] = {proof['key'].hex()} {proof['incarnation']}")
        for part in ("one", "other"):
            name = f"transfer.proof[{n}].{part}"
            lines += [f"{name}.slot = {proof[part]['slot']}"] + update_lines(name, proof[part])
    return lines
