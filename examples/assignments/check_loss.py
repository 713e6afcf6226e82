#!/usr/bin/env python3
"""Checks the assignment "What does loss do?": loss.csv, a sweep, and answers.json, what it says."""

import json
import statistics

from checking import NotYet, check, need, rows

LEAST_SEEDS = 8
LEAST_LOSSES = 4
LEAST_WORDS = 40
NUMBERS = {  # at the highest loss, divided by that without loss
    "fixed_factor": "mean inconsistency (mean_m) of fixed",
    "full_factor": "mean inconsistency (mean_m) of full",
    "fixed_kbit_factor": "traffic (wire_kbps) of fixed",
    "full_kbit_factor": "traffic (wire_kbps) of full",
}
TOLERANCE = 0.03  # of the right number


def measured(path):
    """Rows of loss.csv by technique and loss; refuses a sweep that cannot answer the question."""
    grid = {}
    for row in rows(path):
        if row.get("technique") in ("fixed", "full") and float(row["seconds"]) >= 20:
            grid.setdefault((row["technique"], float(row["loss_percent"])), []).append(row)
    losses = {t: sorted(loss for technique, loss in grid if technique == t) for t in ("fixed", "full")}
    if losses["fixed"] != losses["full"] or not losses["full"]:
        raise NotYet("loss.csv needs runs of at least 20 s by fixed and by full, at the same losses")
    found = losses["full"]
    if found[0] != 0 or found[-1] < 20 or len(found) < LEAST_LOSSES:
        raise NotYet(f"loss.csv has the losses {', '.join(f'{x:g}' for x in found)} %; it needs at least {LEAST_LOSSES}, from 0 to 20 % or more")
    for (technique, loss), runs in sorted(grid.items()):
        if len({row["seed"] for row in runs}) < LEAST_SEEDS:
            raise NotYet(f"loss.csv has {len(runs)} runs of {technique} at {loss:g} %, needs {LEAST_SEEDS} seeds or more")
    if len({(row["peers"], row["delay_ms"], row["jitter_ms"], row["scenario"]) for runs in grid.values() for row in runs}) != 1:
        raise NotYet("loss.csv mixes peers, delays or scenarios; only the loss may differ")
    return grid, found


def factors(grid, losses):
    def mean(technique, loss, column):
        return statistics.mean(float(row[column]) for row in grid[technique, loss])

    return {
        f"{technique}_{name}factor": mean(technique, losses[-1], column) / mean(technique, losses[0], column)
        for technique in ("fixed", "full")
        for name, column in (("", "mean_m"), ("kbit_", "wire_kbps"))
    }


def judge(folder):
    grid, losses = measured(need(folder, "loss.csv"))
    try:
        with open(need(folder, "answers.json"), encoding="utf-8") as file:
            answers = json.load(file)
    except json.JSONDecodeError as e:
        raise NotYet(f"answers.json is no JSON: {e}") from None
    if not isinstance(answers, dict):
        raise NotYet('answers.json must be an object, such as {"fixed_factor": 1.5, ...}')
    right = factors(grid, losses)
    for name, meaning in NUMBERS.items():
        given = answers.get(name)
        if isinstance(given, bool) or not isinstance(given, (int, float)):
            raise NotYet(f"{name} in answers.json must be a number: {meaning} at the highest loss, divided by that without loss")
        if abs(given - right[name]) > TOLERANCE * right[name]:
            raise NotYet(
                f"{name} in answers.json is {given}, and loss.csv says otherwise by more than {TOLERANCE:.0%}; "
                f"it is the {meaning} at the highest loss, divided by that without loss"
            )
    words = len(str(answers.get("why") or "").split())
    if words < LEAST_WORDS:
        raise NotYet(f"'why' in answers.json has {words} words, needs {LEAST_WORDS}")
    return f"{len(losses)} losses, {len(grid)} settings; a person has to judge your 'why'"


check(__doc__, judge)
