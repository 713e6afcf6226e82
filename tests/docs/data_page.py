"""What docs/data.md says that the programs write, by heading; and what differs from that in what they wrote."""

import csv
import json
import re

# What words in capitals may stand for; those that are not here stand for any name without dots and brackets.
STANDS_FOR = {
    "CAUSE": "(threshold|contact_begin|contact_end|proxy|body_threshold|at_rest|leave)",
    "REASON": "(seal|foreign|malformed|duplicate|tick|order|entity|value|signature|right|cut_off|promise)",
    "KNOB": "(threshold|body-threshold|model|lead|foresee|time-space|predictor|threshold-law|convergence|replay|end-update|proxy-update|"
            "rest-state|precision|unowned|time-stamps|budget|radius|steps|count|pcc-bound)",
    "PREDICTOR": "(lookahead|density|path-density|pcc)",
    "SETTING": r"(avatar-only|fixed|adaptive|full)-[\w.-]+",
    "KIND": "(recorded|wander|rest)",
    "MEASURE": "[a-z0-9_]+_(m|ms|s|share|kbps|tick|ticks|out|mismatches|bytes)",
    "SEAL": "(form|unsealed|stranger|replay|tag|cookie|full)",
    "TICK": r"\d+",
    "REGION": r"-?\d+,-?\d+",
}  # fmt: skip


class Row:
    """A name of the page; `optional` if it is there in some cases alone."""

    def __init__(self, name, optional):
        self.name, self.optional = name, optional
        parts = re.split(r"\b([A-Z]{3,})(?=\b|_)|(?<=_)([A-Z]{3,})\b", name)
        self.pattern = "".join(STANDS_FOR.get(p, r"[^.\[\]]+") if re.fullmatch("[A-Z]{3,}", p) else re.escape(p)
                               for p in parts if p)  # fmt: skip

    def fits(self, name):
        return re.fullmatch(self.pattern, name) is not None


def sections(text):
    """The tables of the page by heading, without backticks: lists of (first cell, last cell)."""
    found, heading = {}, None
    for line in text.split("\n"):
        if line.startswith("#"):
            heading = line.lstrip("#").strip().replace("`", "")
        elif heading and re.match(r"\| [`\[]", line):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            found.setdefault(heading, []).append((cells[0], cells[-1]))
    return found


def rows_of(tables, heading, prefix=""):
    """The rows of a heading's table, with those of the tables that it refers to, and what was referred to."""
    rows, used = [], set()
    for first, last in tables[heading]:
        optional = re.search(r"\bOnly\b|\babsent\b", last) is not None
        group = re.fullmatch(r"(?:`([^`]*)`)?\[([^\]]+)\]\(#[\w-]+\)", first)
        if group is None:
            rows.append(Row(prefix + first.strip("`"), optional))
            continue
        name = group[2][0].upper() + group[2][1:]
        if name not in tables:
            raise KeyError(f"{heading}: there is no table '{name}'")
        more, further = rows_of(tables, name, prefix + (group[1] or ""))
        for row in more:
            row.optional = row.optional or optional
        rows += more
        used |= further | {name}
    return rows, used


def names_in_json(value, path=""):
    """The paths of all values; of empty lists and objects, too, marked by what they are."""
    if isinstance(value, dict):
        if not value:
            yield path + "{}"
        for key, inner in value.items():
            yield from names_in_json(inner, f"{path}.{key}" if path else key)
    elif isinstance(value, list):
        if not value:
            yield path + "[]"
        for inner in value:
            yield from names_in_json(inner, path + "[]")
    else:
        yield path


def names_in(file):
    """The columns or fields of a file, by its ending."""
    with open(file, encoding="utf-8", newline="") as opened:
        if file.endswith(".json"):
            return sorted(set(names_in_json(json.load(opened))))
        if file.endswith(".metrics"):
            return re.findall(r"^# HELP (\S+)", opened.read(), re.M)
        return next(csv.reader(line for line in opened if not line.startswith("#")))


def differences(rows, names):
    """What is not on the page, and what is on the page and was not written. A list that is empty has no names within."""
    empty = [name[:-2] for name in names if name.endswith(("[]", "{}")) and not any(row.fits(name) for row in rows)]
    for name in names:
        if name[:-2] in empty and any(row.name.startswith((name[:-2] + "[", name[:-2] + ".")) for row in rows):
            continue
        if not any(row.fits(name) for row in rows):
            yield f"not on the page: {name}"
    for row in rows:
        within = any(re.match(re.escape(place) + r"[\[.]", row.name) for place in empty)
        if not row.optional and not within and not any(row.fits(name) for name in names):
            yield f"on the page, and not written: {row.name}"
