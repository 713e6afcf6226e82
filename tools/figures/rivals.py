"""The tables of what others do, as curves over their knobs beside the curve of `full` over its budget. All stand on one
measurement."""

import json
import os
import shutil

from measuring import metres, table

NETWORKS = {
    "no delay": "delay 0ms",
    "50 ms": "delay 50ms",
    "100 ms": "delay 100ms",
    "250 ms": "delay 250ms",
    "100 ms ± 50 ms, 10 % loss": "delay 100ms 50ms loss 10%",
}
CURVES = ["compare", "--techniques", "frontier", *(word for n in NETWORKS.values() for word in ("--netem", n)), "--seeds", ("3", "1"),
          "--seconds", ("30", "3"), "--json", "-", "--out", "OUT"]  # fmt: skip
BUDGETS = ["full-4kbit", "full-8kbit", "full-16kbit", "full-32kbit", "full"]
TICK = 1 / 60  # s


def rows(m):
    return json.loads(m.lab(*CURVES)[0])["rows"]


def value(row, name):
    return row[name]["mean"]


def pick(of, technique, netem):
    return next(r for r in of if r["technique"] == technique and r["netem"] == netem)


def best_rival(of, full, waits):
    """The least wrong of those that send no more than `full` does, whose avatars follow their hands within a tick, or do not."""
    rivals = [
        r for r in of
        if r["netem"] == full["netem"] and not r["technique"].startswith(("full", "everything"))
        and value(r, "kbit_per_s") <= value(full, "kbit_per_s") and (value(r, "hand_delay_s") >= TICK) == waits
    ]  # fmt: skip
    return min(rivals, key=lambda r: value(r, "mean_m"), default=None)


def told(rival, full):
    """Bold where the rival has less."""
    if rival is None:
        return "-"
    text = f"{metres(value(rival, 'mean_m'))}"
    if value(rival, "mean_m") < value(full, "mean_m"):
        text = f"**{text}**"
    text += f" `{rival['technique']}`"
    if value(rival, "hand_delay_s") >= TICK:
        text += f", {1000 * value(rival, 'hand_delay_s'):.0f} ms, {metres(value(rival, 'hands_mean_m'))}"
    if value(rival, "frozen_share") >= 0.005:
        text += f", frozen {100 * value(rival, 'frozen_share'):.0f} %"
    return text


def budgets(m):
    of = rows(m)
    lines = []
    for name, netem in NETWORKS.items():
        for budget in BUDGETS:
            full = pick(of, budget, netem)
            lines.append([name, f"`{budget}`", f"{value(full, 'kbit_per_s'):.1f}", metres(value(full, "mean_m")),
                          told(best_rival(of, full, False), full), told(best_rival(of, full, True), full)])  # fmt: skip
    return table(["network", "technique", "kbit/s", "mean (m)", "best rival for no more, hand followed at once",
                  "best rival for no more, hand waits"], lines)  # fmt: skip


SHOWN = ["full", "everything", "state-sync-10", "state-sync-20", "state-sync-60", "snapshot-20", "dis-0.3m", "positions", "rollback-0",
         "rollback-2", "rollback-6", "rollback-0-20hz", "rollback-2-20hz", "rollback-6-20hz", "rollback-0-10hz", "lockstep-2", "lockstep-6",
         "lockstep-12", "lockstep-18", "lockstep-12-20hz"]  # fmt: skip


def met(m):
    """What hands and eyes meet."""
    of = rows(m)
    lines = []
    for name in SHOWN:
        cells = []
        for netem in NETWORKS.values():
            r = pick(of, name, netem)
            cells.append(f"{metres(value(r, 'mean_m'))} / {metres(value(r, 'hands_mean_m'))}, {1000 * value(r, 'hand_delay_s'):.0f} ms, "
                         f"{100 * value(r, 'frozen_share'):.0f} %, {value(r, 'jumps_per_s'):.2f}, {value(r, 'kbit_per_s'):.0f}")  # fmt: skip
        lines.append([f"`{name}`", *cells])
    return table(["technique", *NETWORKS], lines)


BRIEFLY = {
    "full": "`full`",
    "full-16kbit": "`full --budget 16`",
    "state-sync-20": "state synchronisation, 20 Hz",
    "snapshot-20": "snapshots, 20 Hz",
    "rollback-0-20hz": "rollback, no input delay, 20 Hz",
    "rollback-0": "rollback, no input delay, 60 Hz",
    "rollback-6": "rollback, input delay 6 ticks, 60 Hz",
    "lockstep-12": "lockstep, input delay 12 ticks, 60 Hz",
}


def briefly(m):
    of = rows(m)
    lines = []
    for name, what in BRIEFLY.items():
        good, bad = pick(of, name, "delay 100ms"), pick(of, name, NETWORKS["100 ms ± 50 ms, 10 % loss"])
        lines.append([what, *(metres(value(pick(of, name, n), "mean_m")) for n in NETWORKS.values()), f"{value(good, 'kbit_per_s'):.0f}",
                      f"{1000 * value(good, 'hand_delay_s'):.0f} ms", f"{100 * value(bad, 'frozen_share'):.0f} %"])  # fmt: skip
    return table(["technique", *(f"{n} (m)" for n in NETWORKS), "kbit/s", "hand to avatar", "frozen, with loss"], lines)


INPUTS = "full,rollback-0,rollback-6,rollback-0-20hz,rollback-6-20hz"
ELSEWHERE = {
    "`clutter`, 200 bodies, 100 ms": ["--scenario", "clutter", "--netem", "delay 100ms", "--seeds", ("2", "1"), "--seconds", ("20", "2")],
    "pitch, 21 peers, 100 ms": ["--scenario", "pitch", "--peers", "21", "--netem", "delay 100ms", "--seeds", "1", "--seconds", ("20", "1")],
    "arena, `delay 30ms trace mobile`": ["--netem", "delay 30ms trace mobile", "--seeds", ("2", "1"), "--seconds", ("30", "3")],
}  # fmt: skip


def elsewhere(m):
    """Those that send inputs alone, where there are many bodies or peers, and where links fail."""
    lines = []
    for where, words in ELSEWHERE.items():
        for r in m.json("compare", "--techniques", INPUTS, *words)["rows"]:
            lines.append([where, f"`{r['technique']}`", metres(value(r, "mean_m")), metres(value(r, "hands_mean_m")),
                          f"{1000 * value(r, 'hand_delay_s'):.0f} ms", f"{100 * value(r, 'frozen_share'):.0f} %",
                          f"{value(r, 'kbit_per_s'):.0f}"])  # fmt: skip
    return table(["where", "technique", "mean (m)", "against hands (m)", "hand to avatar", "frozen", "kbit/s"], lines)


def data_of(picture):
    """The points of one of the pictures."""

    def made(m):
        with open(os.path.join(m.lab(*CURVES)[1], picture + ".csv"), encoding="utf-8") as file:
            return file.read()

    return made


def drawn(picture):
    def draw(m, path):
        shutil.copyfile(os.path.join(m.lab(*CURVES)[1], picture + ".svg"), path)

    return draw
