"""The page of every field of a scenario, from proto/scenario.proto: its messages, rules and comments."""

import re

import pages

SCHEMA = "proto/scenario.proto"
LEFT_OUT = {"Rule", "Vec2", "Range"}  # rules are shown where they hold; the other two are explained at the top
HEAD = """# Scenario files

A scenario is a text in protobuf's text format. Pass it to `--scenario FILE`. `common/scenarios/*.textproto` are the built-in ones; the
comments of `ball.textproto` explain a whole file. The programs check each field, and name the field, the value and the allowed range.

    radius: 0.5                 # a field with a value
    position { x: 3 y: 5.5 }    # a field with fields
    spawn { x: 1 y: 5 }         # a field that may be there several times
    spawn { x: 1 y: 8 }

- *Vec2* has `x` and `y`. *Range* has `min` and `max`; a value is drawn evenly between them by the seed.
- The allowed values hold for both numbers of a Vec2 or a Range.
- Of the fields with the same *one of*, exactly one must be there.
- Lengths are in m, angles in rad, and the y axis points up.

"""


def allowed(kind, rule, default):
    """What a rule says in words: unit, range, how often, default, whether it must be there."""
    said = dict(re.findall(r"(\w+)\s*[:=]\s*(\"[^\"]*\"|[\w.-]+)", rule))
    parts = []
    if "min" in said or "max" in said:
        parts.append(f"{said.get('min', '')} to {said.get('max', '')}")
    if "unit" in said:
        unit = said["unit"].strip('"')
        parts = [f"{parts[0]} {unit}", *parts[1:]] if parts else [unit]
    if kind == "string" and "max_items" in said:
        parts.append(f"up to {said['max_items']} bytes")
    elif "min_items" in said or "max_items" in said:
        parts.append(f"{said.get('min_items', '0')} to {said['max_items']} of them")
    if default is not None:
        parts.append(f"default {default}")
    if said.get("required") == "true":
        parts.append("required")
    return "; ".join(parts)


class Message:
    def __init__(self, name, comment):
        self.name, self.comment, self.rows = name, comment, []


def messages(text):
    """The messages in order, those within others behind them."""
    found, stack, comment, choice = [], [], [], None
    for line in text.split("\n"):
        code, _, trailing = line.strip().partition("//")
        code = code.strip()
        if not code:
            comment = comment + [trailing.strip()] if line.strip().startswith("//") else []
            continue
        opened = re.match(r"message (\w+) \{", code)
        if opened:
            stack.append(Message(".".join([m.name for m in stack] + [opened[1]]) if stack else opened[1], " ".join(comment)))
            found.append(stack[-1])
        elif re.match(r"oneof (\w+) \{", code):
            choice = re.match(r"oneof (\w+)", code)[1]
        elif code == "}" and choice:
            choice = None
        elif code == "}" and stack:
            stack.pop()
        elif stack:
            stack[-1].rows.append(row_of(code, " ".join(comment) or trailing.strip(), choice))
        comment = []
    return found


def row_of(code, comment, choice):
    label, kind, name, options = re.match(r"(?:(optional|repeated) )?(\w+) (\w+) = \d+(?: \[(.*)\])?;", code).groups()
    default = re.search(r"default = ([\w.-]+)", options or "")
    rule = re.search(r"\(rule\)(?:\.(\w+ = [\w.-]+)| = \{(.*?)\})", options or "")
    said = allowed(kind, (rule[1] or rule[2]) if rule else "", default[1] if default else None)
    shown = kind if kind in ("Vec2", "Range") or kind[0].islower() else f"[{kind}](#{pages.anchor_of(kind)})"
    meaning = ". ".join(filter(None, [f"one of: {choice}" if choice else "", comment]))
    several = ", several" if label == "repeated" and "of them" not in said else ""
    return f"| `{name}` | {shown}{several} | {said} | {meaning[:1].upper() + meaning[1:]} |\n"


def page():
    text = pages.read(SCHEMA)
    out = HEAD
    for message in messages(text[text.index("message Rule") :]):
        if message.name in LEFT_OUT:
            continue
        short = message.name.split(".")[-1]
        within = f"Within `{message.name.split('.')[0]}`." if "." in message.name else ""
        out += f"## {short}\n\n{within}{message.comment}\n\n"
        out += "| field | type | allowed | meaning |\n|---|---|---|---|\n" + "".join(message.rows) + "\n"
    return re.sub(r"\n{3,}", "\n\n", out).rstrip("\n") + "\n"
