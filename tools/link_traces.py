#!/usr/bin/env python3
"""Makes the link traces that are built in (--netem "trace NAME"): shell/link_traces/*.link, in the form of mahimahi's packet
delivery traces. Each line is a time in milliseconds at which 1,504 bytes can pass.

Usage: tools/link_traces.py [FOLDER]   (default shell/link_traces)

A recipe says the rate of every millisecond, in bit/s. An opportunity is due whenever 1,504 bytes have come together at that
rate. Chance comes from a seeded generator, so the same recipe makes the same file everywhere.

mobile     120 s. The rate wanders between 50 kbit/s and 2 Mbit/s: every 2 to 8 s a new level is drawn, every 100 ms the rate
           goes a tenth of the way to it, and varies by up to 20 %. Every 15 s on average, nothing passes for 0.3 to 3 s.
satellite  60 s. Every 15 s the link is handed over to another satellite: nothing passes for 150 to 400 ms, and then a new
           rate holds, between 500 kbit/s and 2 Mbit/s. Every 10 ms it varies about that by up to 30 %.
uplink     60 s. A home uplink of 1 Mbit/s. Somebody's upload takes all but 60 kbit/s of it for 4 to 10 s, then leaves it
           alone for 5 to 12 s.
"""

import os
import random
import sys

OPPORTUNITY = 1504 * 8  # bits


class Chance:
    """A seeded generator; of Python's, only random() gives the same numbers in every version."""

    def __init__(self, seed):
        self.generator = random.Random(seed)

    def between(self, low, high):
        return low + (high - low) * self.generator.random()


def mobile():
    chance = Chance(1)
    levels = [50e3, 100e3, 200e3, 400e3, 800e3, 1400e3, 2000e3]
    rate, level, until, outage, now = levels[2], levels[2], 0, 0, 0
    for ms in range(120_000):
        if ms >= until:
            level, until = levels[int(chance.between(0, len(levels)))], ms + chance.between(2_000, 8_000)
        if ms % 100 == 0:
            rate += (level - rate) / 10
            now = min(max(rate * chance.between(0.8, 1.2), 50e3), 2000e3)
            if outage <= 0 and chance.between(0, 15_000) < 100:
                outage = chance.between(300, 3_000)
        outage -= 1
        yield 0 if outage > 0 else now


def satellite():
    chance = Chance(2)
    gap, level, rate = 0, 0, 0
    for ms in range(60_000):
        if ms % 15_000 == 0:
            gap, level = chance.between(150, 400), chance.between(500e3, 2e6)
        if ms % 10 == 0:
            rate = level * chance.between(0.7, 1.3)
        yield 0 if ms % 15_000 < gap else rate


def uplink():
    chance = Chance(3)
    upload, left = False, chance.between(5_000, 12_000)
    for _ in range(60_000):
        if left <= 0:
            upload = not upload
            left = chance.between(4_000, 10_000) if upload else chance.between(5_000, 12_000)
        left -= 1
        yield 60e3 if upload else 1e6


def opportunities(rates):
    bits, times = 0.0, []
    for ms, rate in enumerate(rates):
        bits += rate / 1000
        while bits >= OPPORTUNITY:
            bits -= OPPORTUNITY
            times.append(ms + 1)
    # The last time is how long the trace is.
    times.append(ms + 1)
    return times


def main(arguments):
    if arguments in (["--help"], ["-h"]):
        print(__doc__.strip())
        return 0
    folder = arguments[0] if arguments else os.path.join(os.path.dirname(__file__), "..", "shell", "link_traces")
    if len(arguments) > 1 or not os.path.isdir(folder):
        print(f"link_traces.py: '{arguments[-1]}' is not allowed; give one folder that exists (see --help)", file=sys.stderr)
        return 2
    for recipe in (mobile, satellite, uplink):
        with open(os.path.join(folder, recipe.__name__ + ".link"), "w", encoding="ascii", newline="\n") as file:
            file.writelines(f"{ms}\n" for ms in opportunities(recipe()))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
