#!/usr/bin/env python3
"""Checks the assignment "Guess better": predictor.py, whose predict() must need fewer updates than first-order dead reckoning.

Four paths of one minute are generated. At each of 60 ticks a second the sender predicts as the receivers do, and sends an update
when the prediction is more than 0.3 m off.
"""

import csv
import importlib.util
import math
import os
import tempfile

from checking import NotYet, check, need, run

THRESHOLD = 0.3  # m
SEEDS = (101, 102, 103, 104)
SAVED = 0.10  # of the updates of first-order dead reckoning


def first_order(updates, t):
    u = updates[-1]
    return u["x"] + u["vx"] * (t - u["t"]), u["y"] + u["vy"] * (t - u["t"])


def states(path):
    """What a sender knows at each tick: time, place, velocity and acceleration, from this point and the two before it."""
    with open(path, newline="", encoding="utf-8") as file:
        points = [tuple(map(float, row)) for row in csv.reader(file) if row and row[0][0] not in "#t"]
    told = []
    for i, (t, x, y) in enumerate(points):
        state = {"t": t, "x": x, "y": y, "vx": 0.0, "vy": 0.0, "ax": 0.0, "ay": 0.0}
        if i >= 2:
            (t0, x0, y0), (t1, x1, y1) = points[i - 2], points[i - 1]
            state["vx"], state["vy"] = (x - x1) / (t - t1), (y - y1) / (t - t1)
            state["ax"] = (state["vx"] - (x1 - x0) / (t1 - t0)) / (t - t1)
            state["ay"] = (state["vy"] - (y1 - y0) / (t1 - t0)) / (t - t1)
        told.append(state)
    return told


def updates_needed(path, predict):
    updates = []
    for state in states(path):
        if updates:
            x, y = predict([dict(u) for u in updates[-8:]], state["t"])
            if math.hypot(x - state["x"], y - state["y"]) <= THRESHOLD:
                continue
        updates.append(state)
    return len(updates)


def predictor(path):
    spec = importlib.util.spec_from_file_location("predictor", path)
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        return module.predict
    except (Exception, SystemExit) as e:
        raise NotYet(f"predictor.py cannot be used: {type(e).__name__}: {e}") from None


def judge(folder):
    predict = predictor(need(folder, "predictor.py"))
    yours = theirs = 0
    with tempfile.TemporaryDirectory() as temporary:
        for seed in SEEDS:
            path = os.path.join(temporary, f"{seed}.csv")
            run("padr-lab", "path", "--input", f"wander:{seed}", "--scenario", "arena", "--seconds", "60", "--rate", "60", "--out", path)
            theirs += updates_needed(path, first_order)
            try:
                yours += updates_needed(path, predict)
            except (Exception, SystemExit) as e:
                raise NotYet(f"predict() fails: {type(e).__name__}: {e}") from None
    said = f"you need {yours} updates in four minutes, first-order dead reckoning needs {theirs}"
    if yours > (1 - SAVED) * theirs:
        raise NotYet(f"{said}; save {SAVED:.0%} of them, or more")
    return said


check(__doc__, judge)
