"""A decoded datagram as the standard's test vectors list it: one `name = value` a line."""
from decoder import STATE

STATE_LINES = ("seq", "mark_tick", "mark_count", "have", "have_beyond", "seen_seq", "seen_age", "transit", "loss",
               "incarnation", "to_incarnation")  # fmt: skip


def listing(decoded):
    lines = [f"{name} = {decoded[name]}" for name in ("kind", "sender", "session")]
    lines += state_lines(decoded) if decoded["kind"] == STATE else message_lines(*decoded["message"])
    return lines


def shown(value):
    """Numbers as the vectors have them: floats with nine significant digits, flags as 0 and 1."""
    if isinstance(value, tuple):
        return " ".join(shown(part) for part in value)
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, bytes):
        return value.hex()
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def of(prefix, values, names):
    """The lines of those names that have a value."""
    return [f"{prefix}.{name} = {shown(values[name])}" for name in names if values[name] is not None]


def state_lines(decoded):
    lines = [f"{name} = {decoded[name]}" for name in STATE_LINES]
    if decoded["check_hash"]:
        lines += [f"{name} = {decoded[name]}" for name in ("check_tick", "check_hash")]
    for n, update in enumerate(decoded["updates"]):
        lines += update_lines(f"update[{n}]", update)
    return lines


def update_lines(prefix, update):
    lines = of(prefix, update, ("index", "tick"))
    lines += [f"{prefix}.{flag} = 1" for flag in ("leave", "spectates") if update[flag]]
    if update["avatar"]:
        lines += of(f"{prefix}.avatar", update["avatar"], ("cause", "model", "awake", "position", "velocity", "control"))
    for body in update["bodies"]:
        name = f"{prefix}.body[{body['id']}]"
        lines += of(name, body, ("cause", "held", "release"))
        if body["state"]:
            lines += of(name, body["state"], ("epoch", "claimed", "awake", "position", "angle", "velocity", "spin"))
    return lines + order_lines(prefix, update)


def order_lines(prefix, update):
    lines, admission, passed_on = [], update["admission"], update["passed_on"]
    if admission:
        lines += of(f"{prefix}.admission", admission, ("slot", "incarnation", "first", "address", "port"))
        lines += [f"{prefix}.admission.have[{slot}] = {have}" for slot, have in enumerate(admission["have"])]
        lines += [f"{prefix}.admission.spectator = 1"] if admission["spectator"] else []
    for removal in update["removals"]:
        lines.append(f"{prefix}.removal[{removal['slot']}] = {removal['incarnation']} {removal['count']}")
    if update["signature"]:
        lines.append(f"{prefix}.signature = {shown(update['signature'])}")
    if passed_on:
        lines += of(f"{prefix}.passed_on", passed_on, ("slot",)) + update_lines(f"{prefix}.passed_on", passed_on)
    return lines


def message_lines(name, content):
    lines = []
    for field, value in content.items():
        if field in ("member", "lost"):
            lines += [f"{name}.{field}[{n}] = {seat['slot']} {seat['incarnation']} {seat['have']} {seat['heard']}" for n, seat in enumerate(value)]
        elif name == "reach" and field == "heard":
            lines += [f"reach.heard[{n}] = {way['slot']} {way['delay']} {int(way['carried'])}" for n, way in enumerate(value)]
        elif name == "reach" and field == "at":
            lines += [f"reach.at[{n}] = {place(each)}" for n, each in enumerate(value)]
        elif field == "known":
            lines += [f"tell.known[{n}] = {place(each)} in{regions(each['in'])} seeks{regions(each['seeks'])}"
                      for n, each in enumerate(value)]  # fmt: skip
        elif field in ("in", "seeks"):
            lines.append(f"{name}.{field} ={regions(value)}")
        elif field == "update":
            lines += [line for n, update in enumerate(value) for line in update_lines(f"{name}.update[{n}]", update)]
        elif field != "padding" and value != b"":
            lines.append(f"{name}.{field} = {shown(value)}")
    return lines


def regions(numbers):
    return "".join(f" {number}" for number in numbers)


def place(endpoint):
    return f"{shown(endpoint['address'])} {endpoint['port']}"
