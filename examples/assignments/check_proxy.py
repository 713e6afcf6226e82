#!/usr/bin/env python3
"""Checks the assignment "The worst chain": path.csv, on which collisions by proxy do most damage when nobody tells of them.

Peer 0 follows the path in scenario proxy by technique adaptive, once without and once with updates for what is touched by proxy.
The score is by how much bodies are further off in the view of peer 1 without them, in metres, on average over 10 s.
"""

import json

from checking import NotYet, check, need, run

ENOUGH = 1.0  # m
LONGEST = 10  # s


def bodies_off(path, proxy_update):
    done = run(
        "padr-lab", "run", "--scenario", "proxy", "--peers", "2", "--technique", "adaptive", "--proxy-update", proxy_update,
        "--input", f"path:{path}", "--input", "rest", "--seconds", "10", "--settle", "2", "--watch", "1", "--fidelity", "off", "--json", "-",
    )  # fmt: skip
    if done.returncode != 0:
        raise NotYet(done.stderr.strip())
    warnings = [line for line in done.stderr.splitlines() if "warning" in line]
    if warnings:
        raise NotYet(f"padr-lab warns of the path: {warnings[0].split('warning: ')[1]}")
    return json.loads(done.stdout)["body_mean_m"]


def judge(folder):
    path = need(folder, "path.csv")
    with open(path, encoding="utf-8") as file:
        lines = [line.strip() for line in file if line.strip() and not line.startswith("#")]
    if lines[:1] != ["t,x,y"] or len(lines) < 3:
        raise NotYet("path.csv must begin with the line t,x,y and have two points or more")
    try:
        seconds = float(lines[-1].split(",")[0])
    except ValueError:
        raise NotYet(f"the last line of path.csv is '{lines[-1]}', and must be t,x,y in numbers") from None
    if seconds > LONGEST:
        raise NotYet(f"the path takes {seconds:g} s, may take {LONGEST} s")
    without, told = bodies_off(path, "off"), bodies_off(path, "on")
    said = f"bodies are {without:.2f} m off without updates by proxy and {told:.2f} m with them: score {without - told:.2f}"
    if without - told < ENOUGH:
        raise NotYet(f"{said}; reach {ENOUGH:.2f}")
    return said


check(__doc__, judge)
