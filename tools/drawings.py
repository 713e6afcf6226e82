#!/usr/bin/env python3
"""Draws the explaining pictures of the documents: docs/paper-dead-reckoning.svg and docs/paper-loop.svg, which are what the
paper's Figures 1 and 5 are about, and docs/agreed-world.svg.

Usage: tools/drawings.py [FOLDER]   (default docs)
"""

import math
import os
import sys

# A colour stands before each variable for programs that know no variables.
STYLE = """<style>
  svg { --paper: #ffffff; --ink: #1f2328; --quiet: #5c6570; --true: #0072b2; --model: #c25100; --box: #eef2f6; --rule: #8a949e; }
  @media (prefers-color-scheme: dark) {
    svg { --paper: #0d1117; --ink: #e6edf3; --quiet: #9aa4af; --true: #56b4e9; --model: #f0883e; --box: #1c232c; --rule: #6e7781; }
  }
  .paper { fill: #ffffff; fill: var(--paper); } text { fill: #1f2328; fill: var(--ink); font: 14px sans-serif; } .quiet { fill: #5c6570; fill: var(--quiet); font-size: 12px; }
  .true { fill: none; stroke: #0072b2; stroke: var(--true); stroke-width: 3; } .model { fill: none; stroke: #c25100; stroke: var(--model); stroke-width: 2; stroke-dasharray: 7 4; }
  .gap { stroke: #5c6570; stroke: var(--quiet); stroke-width: 1.5; } .dot { fill: #0072b2; fill: var(--true); } .ghost { fill: #ffffff; fill: var(--paper); stroke: #c25100; stroke: var(--model); stroke-width: 2; }
  .box { fill: #eef2f6; fill: var(--box); stroke: #8a949e; stroke: var(--rule); } .way, .join { fill: none; stroke: #8a949e; stroke: var(--rule); stroke-width: 1.8; } .way { marker-end: url(#tip); }
  .tip { fill: #8a949e; fill: var(--rule); } .middle { text-anchor: middle; } .end { text-anchor: end; }
</style>"""


def picture(width, height, title, parts):
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img">'
    tip = '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto"><path class="tip" d="M0 0L8 4L0 8z"/></marker></defs>'
    return "\n".join([head, f"<title>{title}</title>", STYLE, tip, f'<rect class="paper" width="{width}" height="{height}"/>', *parts, "</svg>\n"])


def text(x, y, words, kind=""):
    return f'<text x="{x:g}" y="{y:g}" class="{kind}">{words}</text>'


# --- dead reckoning: an avatar on a curve, and its first-order model, by the rule itself
THRESHOLD = 42.0  # in the picture's units
STEP = 1 / 60  # s
LAST = 5.6  # s


def avatar(t):
    return 60 + 118 * t, 150 - 62 * math.sin(1.35 * t) - 18 * math.sin(2.9 * t + 0.4)


def dead_reckoning():
    """What the model did from each update on: (where the update was, where the model ended, where the avatar was then)."""
    told, t, ways = 0.0, 0.0, []
    while t < LAST:
        t += STEP
        (x, y), (ahead_x, ahead_y) = avatar(told), avatar(told + STEP)
        passed = (t - told) / STEP
        model = x + (ahead_x - x) * passed, y + (ahead_y - y) * passed
        if math.dist(model, avatar(t)) > THRESHOLD or t >= LAST:
            ways.append(((x, y), model, avatar(t)))
            told = t
    return ways


def draw_dead_reckoning():
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in (avatar(i * STEP) for i in range(int(LAST / STEP) + 1)))
    parts = [f'<polyline class="true" points="{line}"/>']
    ways = dead_reckoning()
    for i, ((ax, ay), (mx, my), (tx, ty)) in enumerate(ways):
        parts.append(f'<line class="model" x1="{ax:.1f}" y1="{ay:.1f}" x2="{mx:.1f}" y2="{my:.1f}"/>')
        if i + 1 < len(ways):  # the last one is still on its way
            parts.append(f'<line class="gap" x1="{mx:.1f}" y1="{my:.1f}" x2="{tx:.1f}" y2="{ty:.1f}"/>')
            parts.append(f'<circle class="ghost" cx="{mx:.1f}" cy="{my:.1f}" r="4.5"/>')
    for (x, y), _, _ in ways:
        parts.append(f'<circle class="dot" cx="{x:.1f}" cy="{y:.1f}" r="6"/>')
    y = 292
    parts += [f'<line class="true" x1="40" y1="{y}" x2="80" y2="{y}"/>', text(88, y + 5, "where the avatar is"),
              f'<line class="model" x1="245" y1="{y}" x2="285" y2="{y}"/>', text(293, y + 5, "where the others believe it to be"),
              f'<circle class="dot" cx="535" cy="{y}" r="6"/>', text(547, y + 5, "an update: position and velocity"),
              f'<line class="gap" x1="40" y1="{y + 28}" x2="80" y2="{y + 28}"/><circle class="ghost" cx="40" cy="{y + 28}" r="4.5"/>',
              text(88, y + 33, "the error has reached the threshold, so an update goes out, and the model goes on from there")]  # fmt: skip
    return picture(780, 345, "Dead reckoning: the model keeps the velocity of the last update until it is wrong by the threshold", parts)


# --- the loop: one tick of a peer
def box(x, y, words, where, width=250):
    return [f'<rect class="box" x="{x}" y="{y}" width="{width}" height="48" rx="8"/>', text(x + width / 2, y + 21, words, "middle"),
            text(x + width / 2, y + 38, where, "middle quiet")]  # fmt: skip


def question(x, y, words, where):
    points = f"{x},{y + 34} {x + 40},{y} {x + 210},{y} {x + 250},{y + 34} {x + 210},{y + 68} {x + 40},{y + 68}"
    return [f'<polygon class="box" points="{points}"/>', text(x + 125, y + 30, words, "middle"), text(x + 125, y + 48, where, "middle quiet")]


def way(*points, tip="way"):
    return f'<path class="{tip}" d="M' + "L".join(f"{x} {y}" for x, y in points) + '"/>'


def draw_loop():
    left, right = 60, 430
    parts = [*box(left, 30, "sample the input", "peer/player.cpp"), *box(left, 108, "apply received updates", "sync/agreed_world.cpp"),
             *box(left, 186, "step the world", "reckoning/live_world.cpp"),
             *question(left, 264, "contact begun or ended?", "reckoning/contact_chain.cpp"),
             *box(right, 274, "predict what the error costs", "reckoning/prediction.cpp"),
             *box(right, 352, "set the threshold", "reckoning/threshold.cpp"),
             *question(right, 430, "model error above it?", "reckoning/model_error.h"),
             *box(left, 380, "tell the avatar and the bodies", "reckoning/reporter.cpp"),
             *box(left, 440 + 68, "tell the avatar", "reckoning/reporter.cpp")]  # fmt: skip
    middle, other = left + 125, right + 125
    parts += [way((middle, 78), (middle, 106)), way((middle, 156), (middle, 184)), way((middle, 234), (middle, 262)),
              way((left + 250, 298), (right - 2, 298)), text(left + 258, 291, "no"), way((middle, 332), (middle, 378)), text(middle + 8, 358, "yes"),
              way((other, 322), (other, 350)), way((other, 400), (other, 428)),
              way((right, 464), (345, 464), (345, 532), (left + 252, 532)), text(right - 32, 457, "yes"),
              # back to the beginning
              way((left, 404), (25, 404), (25, 54), (left - 2, 54)), way((left, 532), (25, 532), (25, 404), tip="join"),
              way((right + 250, 464), (725, 464), (725, 54), (left + 252, 54)), text(right + 256, 457, "no"),
              text(500, 47, "next tick", "quiet")]  # fmt: skip
    return picture(760, 590, "One tick of a peer: the paper's loop, with the files that do each step here", parts)


# --- the agreed world: what is known of three peers at one moment, at one of them
NOW, CONFIRMED, LATE = 640, 330, 400  # where these ticks are


def log(y, name, ticks, complete):
    """A peer's updates as far as they have come, and up to where it is known that there are no others."""
    parts = [text(20, y + 5, name), f'<line class="gap" x1="130" y1="{y}" x2="{complete}" y2="{y}"/>',
             f'<line class="gap" x1="{complete}" y1="{y - 7}" x2="{complete}" y2="{y + 7}"/>']  # fmt: skip
    return parts + [f'<circle class="dot" cx="{x}" cy="{y}" r="5"/>' for x in ticks]


def draw_agreed_world():
    parts = [f'<rect class="box" x="130" y="44" width="{CONFIRMED - 130}" height="246"/>',
             text(20, 30, "what has come of", "quiet"), text(NOW, 30, "now", "middle"),
             *log(70, "peer 0 (here)", [160, 270, 390, 510, 600], NOW), *log(105, "peer 1", [185, 300, 445], 470),
             *log(140, "peer 2", [210, 305], CONFIRMED),
             f'<line class="gap" x1="{NOW}" y1="40" x2="{NOW}" y2="290"/>',
             # the late update, and what it sets off
             f'<circle class="ghost" cx="{LATE}" cy="140" r="6"/>', way((NOW - 4, 140), (LATE + 10, 140)),
             text(NOW - 8, 132, "a late update arrives", "quiet end"),
             f'<line class="true" x1="130" y1="200" x2="{CONFIRMED}" y2="200"/>', text(20, 205, "confirmed"),
             text(230, 190, "identical on every peer", "middle quiet"),
             f'<line class="model" x1="{CONFIRMED}" y1="235" x2="{NOW}" y2="235"/>', text(20, 240, "predicted"),
             way((NOW - 6, 252), (LATE, 252), (LATE, 239)), text((LATE + NOW) / 2, 268, "rewind to its tick, replay to now", "middle quiet"),
             f'<circle class="dot" cx="{NOW}" cy="280" r="7"/>', text(20, 285, "live"),
             text(NOW + 14, 275, "your avatar"), text(NOW + 14, 292, "obeys at once"),
             text(20, 314, "A line ends where that peer's updates are known to be complete. Up to where all lines reach, nothing can change.", "quiet")]  # fmt: skip
    return picture(780, 330, "The agreed world: confirmed where all updates are known, predicted up to now, live for the own avatar", parts)


def main(arguments):
    if arguments in (["--help"], ["-h"]):
        print(__doc__.strip())
        return 0
    folder = arguments[0] if arguments else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs")
    if len(arguments) > 1 or not os.path.isdir(folder):
        print(f"drawings.py: '{arguments[-1]}' is not allowed; give one folder that exists (see --help)", file=sys.stderr)
        return 2
    drawings = {"paper-dead-reckoning": draw_dead_reckoning, "paper-loop": draw_loop, "agreed-world": draw_agreed_world}
    for name, draw in drawings.items():
        with open(os.path.join(folder, f"{name}.svg"), "w", encoding="utf-8") as f:
            f.write(draw())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
