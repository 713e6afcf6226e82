#!/usr/bin/env python3
"""Checks the assignment "Who owned what?": owners.py, which must rebuild authority from game.pcapng, a capture of three peers,
and from merged.csv, events that come in any order.

owners.py is called as `owners.py EVENTS.csv TICK` and prints a line `BODY PEER` for each body that is owned then.
"""

import os
import subprocess
import sys
import tempfile

from checking import NotYet, check, need, rows, run

TICKS = 40  # at which both are compared
PATIENCE = 30  # s for one call of owners.py

# Who owns which body of merged.csv at these ticks.
MERGED = {
    60: {3: 0}, 90: {5: 1}, 112: {3: 2, 5: 1}, 120: {3: 2, 5: 1, 8: 0}, 130: {3: 2, 5: 1, 8: 0}, 160: {3: 2, 8: 0}, 200: {8: 0},
    210: {5: 2, 8: 0}, 235: {5: 2, 8: 0}, 245: {5: 2, 8: 0}, 260: {5: 1, 8: 0}, 270: {5: 1, 8: 1}, 300: {5: 1, 8: 1},
}  # fmt: skip


def truth(capture, folder):
    """Owners of bodies by tick, as every peer had them in its confirmed world; and the events."""
    states, events = os.path.join(folder, "states.csv"), os.path.join(folder, "events.csv")
    done = run("padr-capture", "rebuild", capture, "--csv", states)
    if done.returncode != 0:
        raise NotYet(f"game.pcapng cannot be rebuilt: {(done.stdout + done.stderr).strip()}")
    run("padr-capture", "timeline", capture, "--csv", events)
    owners, bodies = {}, set()
    for row in rows(states):
        tick, entity = int(row["tick"]), int(row["entity"])
        here = owners.setdefault(tick, {})
        if tick == 0 and row["owner"] == "":
            bodies.add(entity)  # an avatar has an owner from the beginning
        if row["owner"] != "" and entity in bodies:
            here[entity] = int(row["owner"])
    return owners, events


def worth_it(events):
    listed = rows(events)
    names = [row["event"] for row in listed]
    peers = {row["peer"] for row in listed if row["event"] == "heard"}
    if len(peers) < 3 or names.count("claim") < 15 or names.count("resend") < 3:
        raise NotYet(
            f"game.pcapng has {len(peers)} peers, {names.count('claim')} claims and {names.count('resend')} updates sent again; "
            "it needs 3, 15 and 3: play longer, with loss"
        )


def owners_by(script, events, tick):
    try:
        done = subprocess.run([sys.executable, "-B", script, events, str(tick)], capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        raise NotYet(f"owners.py takes more than {PATIENCE} s at tick {tick}") from None
    if done.returncode != 0:
        raise NotYet(f"owners.py fails at tick {tick}: {done.stderr.strip()[-300:]}")
    try:
        return {int(body): int(peer) for body, peer in (line.split() for line in done.stdout.splitlines())}
    except ValueError:
        raise NotYet(f"owners.py prints '{done.stdout.strip()[:80]}'; it must print lines of BODY PEER") from None


def compare(script, events, right, what):
    """Refuses owners.py if it says anything else at one of the ticks of `right`."""
    wrong = []
    for tick, expected in right.items():
        given = owners_by(script, events, tick)
        if given != expected:
            wrong.append((tick, given, expected))
    if not wrong:
        return
    tick, given, expected = wrong[0]
    other = sorted(body for body in given.keys() | expected.keys() if given.get(body) != expected.get(body))
    bodies = ", ".join(f"body {b}: yours {name(given.get(b))}, really {name(expected.get(b))}" for b in other[:3])
    more = f", and {len(other) - 3} more" if len(other) > 3 else ""
    raise NotYet(f"{len(wrong)} of {len(right)} ticks of {what} are wrong; the first is tick {tick} ({bodies}{more})")


def name(peer):
    return "nobody" if peer is None else f"peer {peer}"


def judge(folder):
    script, capture = need(folder, "owners.py"), need(folder, "game.pcapng")
    with tempfile.TemporaryDirectory() as temporary:
        right, events = truth(capture, temporary)
        worth_it(events)
        last = max(right)
        chosen = [last * i // TICKS for i in range(1, TICKS + 1)]
        compare(script, events, {tick: right[tick] for tick in chosen}, "game.pcapng")
    compare(script, os.path.join(os.path.dirname(os.path.abspath(__file__)), "owners", "merged.csv"), MERGED, "merged.csv")
    return f"all {TICKS} ticks of game.pcapng are as in the confirmed world, and all {len(MERGED)} of merged.csv"


check(__doc__, judge)
