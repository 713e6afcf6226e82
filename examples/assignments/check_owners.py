#!/usr/bin/env python3
"""Checks the assignment "Who owned what?": owners.py, which must rebuild authority from game.pcapng, a capture of three peers.

owners.py is called as `owners.py EVENTS.csv TICK` and prints a line `BODY PEER` for each body that is owned then.
"""

import os
import subprocess
import sys
import tempfile

from checking import NotYet, check, need, rows, run

TICKS = 40  # at which both are compared


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
    done = subprocess.run([sys.executable, "-B", script, events, str(tick)], capture_output=True, text=True, timeout=30, check=False)
    if done.returncode != 0:
        raise NotYet(f"owners.py fails at tick {tick}: {done.stderr.strip()[-300:]}")
    try:
        return {int(body): int(peer) for body, peer in (line.split() for line in done.stdout.splitlines())}
    except ValueError:
        raise NotYet(f"owners.py prints '{done.stdout.strip()[:80]}'; it must print lines of BODY PEER") from None


def judge(folder):
    script, capture = need(folder, "owners.py"), need(folder, "game.pcapng")
    with tempfile.TemporaryDirectory() as temporary:
        right, events = truth(capture, temporary)
        worth_it(events)
        last, wrong = max(right), []
        for tick in (last * i // TICKS for i in range(1, TICKS + 1)):
            given = owners_by(script, events, tick)
            if given != right[tick]:
                wrong.append((tick, given, right[tick]))
    if wrong:
        tick, given, expected = wrong[0]
        raise NotYet(f"{len(wrong)} of {TICKS} ticks are wrong; the first is tick {tick}: yours {given}, in the confirmed world {expected}")
    return f"{TICKS} of {TICKS} ticks are as in the confirmed world"


check(__doc__, judge)
