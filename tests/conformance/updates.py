"""An update: what one peer tells of one tick, sections 3 and 4."""
import math

from protobuf import Single, message
from rules import ascends, check_floats, check_length, require, require_place, require_value

CAUSES = ("threshold", "contact_begin", "contact_end", "proxy", "body_threshold", "at_rest", "leave")
MODELS = ("static", "first", "second", "input")
MODELS_WITH_CONTROL = ("second", "input")
MOST_BODIES, MOST_SIGNED_BODIES, SIGNATURE = 27, 20, 64
FIRST_BAD_BODY = 65535
MOST_PEERS = 64
MOST_PASSING = 3
MOST_TICK = (1 << 31) - 2
MOST_SPEED, MOST_SPIN, MOST_ANGLE, MOST_CONTROL, MOST_EPOCH = 121, 95, 100000, 10000, 1 << 30
MOST_NUMBER = (1 << 30) - 1
PLACE, MOTION = 1 / (1 << 14), 1 / (1 << 12)
MOST_STEPS = (1 << 24) - 1

ADMISSION_FIELDS = {
    1: ("slot", "uint32"), 2: ("incarnation", "uint32"), 3: ("first", "uint32"), 4: ("address", "bytes"),
    5: ("port", "uint32"), 6: ("have", "uint32 column"), 7: ("spectator", "bool"),
}
REMOVAL_FIELDS = {1: ("slot", "uint32"), 2: ("incarnation", "uint32"), 3: ("count", "uint32")}
PASSED_ON_FIELDS = {1: ("slot", "uint32"), 2: ("index", "uint32"), 3: ("tick", "uint32")}
PASSAGE_FIELDS = {
    1: ("region", "uint32"), 2: ("number", "uint32"), 3: ("crossings", "uint32"), 4: ("flags", "uint32"),
    5: ("state", "float column"), 6: ("to", "uint32"), 7: ("rounded", "sint32 column"),
}
MOST_PASSAGES, MOST_BODY_NUMBER = 8, (1 << 16) - 1
UPDATE_FIELDS = {
    1: ("index_back", "uint32"), 2: ("tick_back", "uint32"), 3: ("avatar", "uint32"), 4: ("bodies", "uint32 column"),
    5: ("state", "float column"), 6: ("rounded", "sint32 column"), 10: ("leave", "bool"),
    11: ("admission", Single(ADMISSION_FIELDS)), 12: ("removals", REMOVAL_FIELDS),
    13: ("passed_on", Single(PASSED_ON_FIELDS)), 14: ("signature", "bytes"),
    15: ("passages", PASSAGE_FIELDS), 16: ("going", "uint32"), 17: ("spectates", "bool"),
}
PASSED_ON_FIELDS[4] = ("update", Single(UPDATE_FIELDS))


def decode_update(raw, mark_tick, mark_count, depth=0):
    sorts = (raw["leave"], raw["admission"] is not None, bool(raw["removals"]), raw["passed_on"] is not None,
             raw["avatar"] != 0 or len(raw["bodies"]) > 0, bool(raw["passages"]), raw["going"] != 0, raw["spectates"])  # fmt: skip
    require(sum(sorts) <= 1, "an update of two sorts")
    require(raw["index_back"] < mark_count, "a number below 0")
    require(raw["tick_back"] <= mark_tick, "a tick before the start")
    signature = raw["signature"]
    require(len(signature) in (0, SIGNATURE), "a signature of another length")
    tick = mark_tick - raw["tick_back"]
    values = Values(raw)
    avatar = decode_avatar(raw["avatar"], values)
    bodies = decode_bodies(raw["bodies"], values, tick)
    values.end()
    require(len(bodies) <= (MOST_SIGNED_BODIES if signature else MOST_BODIES), "too many bodies")
    return {"index": mark_count - 1 - raw["index_back"], "tick": tick, "leave": raw["leave"],
            "spectates": raw["spectates"],
            "avatar": avatar, "bodies": bodies, "admission": decode_admission(raw["admission"]),
            "removals": decode_removals(raw["removals"]), "passed_on": decode_passed_on(raw["passed_on"], depth),
            "signature": signature, "passages": decode_passages(raw["passages"]), "going": decode_going(raw["going"])}  # fmt: skip


def decode_going(raw):
    require(raw <= 2, "neither going nor staying")
    return raw


def decode_passages(raw):
    require(len(raw) <= MOST_PASSAGES, "too many passages")
    for passage in raw:
        kind, flags = passage["flags"] & 3, passage["flags"]
        require(kind < 3 and flags < 1 << 12, "a passage that is none")
        require(passage["number"] <= MOST_BODY_NUMBER and 1 <= passage["crossings"] <= MOST_NUMBER, "a body that is none")
        require(kind == 1 or (flags < 4 and not passage["state"] and not passage["rounded"]), "a state of what does not come in")
        require(kind == 0 or passage["to"] == 0, "bound, and on its way")
        if kind == 1:
            values = Values(passage)
            decode_motion(values, bool(flags & 8))
            values.end()
    return raw


def decode_admission(raw):
    if raw is None:
        return None
    require(raw["slot"] < MOST_PEERS and len(raw["have"]) <= MOST_PEERS, "more slots than there may be")
    require_place(raw)
    return {**raw, "have": tuple(raw["have"])}


def decode_removals(raw):
    require(all(removal["slot"] < MOST_PEERS for removal in raw), "a slot that is none")
    require(ascends([removal["slot"] for removal in raw]), "removals do not ascend")
    return raw


def decode_passed_on(raw, depth):
    if raw is None:
        return None
    require(depth < MOST_PASSING, "updates that lie too deep")
    require(raw["slot"] < MOST_PEERS, "a slot that is none")
    require(raw["tick"] <= MOST_TICK and raw["index"] < (1 << 32) - 1, "a tick or number that is none")
    inner = raw["update"] or message(b"", UPDATE_FIELDS)
    return {"slot": raw["slot"], **decode_update(inner, raw["tick"], raw["index"] + 1, depth + 1)}


def cause_of(flags):
    require(flags & 7 < len(CAUSES), "a cause that is none")
    return CAUSES[flags & 7]


def decode_avatar(flags, values):
    if flags == 0:
        return None
    require(flags & 0x40 and flags < 0x80, "flags of an avatar")
    model = MODELS[flags >> 3 & 3]
    position, velocity = values.take(2, PLACE), values.take(2, MOTION)
    control = values.take(2, PLACE if model == "input" else MOTION) if model in MODELS_WITH_CONTROL else None
    return {"cause": cause_of(flags), "model": model, "awake": bool(flags & 0x20), "position": position,
            "velocity": velocity, "control": control}


def decode_bodies(column, values, tick):
    bodies, numbers, next_id = [], iter(column), 0
    for head in numbers:
        bodies.append(decode_body(next_id + head // 128, head % 128, numbers, values, tick))
        next_id = bodies[-1]["id"] + 1
    return bodies


def decode_body(id, flags, numbers, values, tick):
    require(id < FIRST_BAD_BODY, "a body id that is none")
    body = {"id": id, "flags": flags, "cause": cause_of(flags), "held": bool(flags & 8), "release": bool(flags & 0x20),
            "state": None}  # fmt: skip
    awake = bool(flags & 0x40)
    if not flags & 0x10:
        require(not awake, "awake without a state")
        return body
    epoch, claim_age = next_of(numbers), next_of(numbers)
    require(claim_age <= tick, "a claim of before the start")
    body["state"] = {"epoch": epoch, "claim_age": claim_age, "claimed": tick - claim_age, "awake": awake,
                     **decode_motion(values, awake)}  # fmt: skip
    return body


def decode_motion(values, awake):
    position, (angle,) = values.take(2, PLACE), values.take(1, PLACE)
    velocity, (spin,) = (values.take(2, MOTION), values.take(1, MOTION)) if awake else (None, (None,))
    return {"position": position, "angle": angle, "velocity": velocity, "spin": spin}


class Values:
    """Of one of the two columns, `rounded` if there is anything in it, one after another."""

    def __init__(self, raw):
        require(not raw["state"] or not raw["rounded"], "values told in two ways")
        self.in_steps = len(raw["rounded"]) > 0
        self.column = iter(raw["rounded"] if self.in_steps else raw["state"])
        self.floats_needed = len(raw["state"]) == 0

    def take(self, count, step):
        return tuple(self.value(next_of(self.column), step) for _ in range(count))

    def value(self, told, step):
        if self.in_steps:
            require(abs(told) <= MOST_STEPS, "more steps than there may be")
            return told * step
        self.floats_needed = self.floats_needed or not is_in_steps(told, step)
        return told

    def end(self):
        require(next(self.column, None) is None, "values that belong to nothing")
        require(self.in_steps or self.floats_needed, "floats that are whole steps")


def is_in_steps(value, step):
    if not abs(value) <= MOST_STEPS * step or (value == 0 and math.copysign(1, value) < 0):
        return False
    return (value / step).is_integer()


def next_of(column):
    value = next(column, None)
    require(value is not None, "a column is too short")
    return value


def check_values(update, sender):
    """The ranges of section 4, but for those of which the session or the scenario knows: slots, bodies, bounds of positions."""
    check_orders(update, sender)
    for passage in update["passages"]:
        check_passage(passage)
    for state in (body["state"] for body in update["bodies"] if body["state"]):
        require_value(1 <= state["epoch"] <= MOST_EPOCH, "epoch")
        check_floats(state["position"], math.inf)
        check_floats((state["angle"],), MOST_ANGLE)
        if state["awake"]:
            check_length(state["velocity"], MOST_SPEED)
            check_floats((state["spin"],), MOST_SPIN)
    avatar = update["avatar"]
    if avatar:
        check_floats(avatar["position"], math.inf)
        check_length(avatar["velocity"], MOST_SPEED)
        check_length(avatar["control"] or (), MOST_CONTROL)
        require_value(avatar["awake"] or avatar["velocity"] == (0, 0), "an avatar asleep that moves")


def check_passage(passage):
    """Section 15, but for what the session knows: whether it is a region, which one, and of which builds its bodies are."""
    kind, state = passage["flags"] & 3, passage["state"]
    require_value(kind != 0 or passage["to"] != 0, "bound for nowhere")
    if kind == 1:
        check_floats(state[:2], math.inf)
        check_floats(state[2:3], MOST_ANGLE)
        check_length(state[3:5], MOST_SPEED)
        check_floats(state[5:], MOST_SPIN)


def check_orders(update, sender):
    admission, passed_on = update["admission"], update["passed_on"]
    if admission:
        require_value(admission["slot"] != sender and admission["incarnation"] > 0, "an admission of oneself or nobody")
        numbers = (admission["incarnation"], admission["first"], *admission["have"])
        require_value(max(numbers) <= MOST_NUMBER, "numbers of an admission")
    for removal in update["removals"]:
        require_value(removal["slot"] != sender, "a removal of oneself")
        require_value(max(removal["incarnation"], removal["count"]) <= MOST_NUMBER, "numbers of a removal")
    if passed_on:
        require_value(passed_on["slot"] != sender, "passes on its own")
        require_value(passed_on["index"] <= MOST_NUMBER and passed_on["tick"] <= update["tick"], "passes on what is not yet")
        check_values(passed_on, passed_on["slot"])
