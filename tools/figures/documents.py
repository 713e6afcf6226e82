"""Every table and picture with figures in the documents: where it stands and how it is measured."""

import csv
import json
import os
import re
import shutil
import subprocess

import rivals
from measuring import Failed, interval, mean, metres, table


class Figure:
    """A table between marks in a document."""

    is_table = True

    def __init__(self, name, file, made):
        self.name = name
        self.file = file
        self.made = made  # Measuring -> its text

    def draw(self, measuring, folder):
        """Pictures are drawn, tables are not."""


class Picture(Figure):
    """A file in docs. What is compared is the data, as programs that draw differ from system to system."""

    is_table = False

    def __init__(self, name, made, drawn):
        super().__init__(name + ".svg", f"docs/{name}.svg", made)
        self.drawn = drawn  # (Measuring, path) -> None

    def draw(self, measuring, folder):
        self.drawn(measuring, os.path.join(folder, self.name))


# --- four techniques on a bad network

BAD = ["--delay", "100ms", "--jitter", "50ms", "--loss", "10%"]
SEEDS = ("1-40", "1-2")
WHAT_THEY_ARE = {
    "avatar-only": "dead reckoning of avatars, no authority: the paper's failure case",
    "fixed": "the paper's dynamic authority, one threshold of 0.5 m",
    "adaptive": "the paper's technique: a threshold of 0.8 m, and of 0.3 m when a contact is predicted",
    "full": "`adaptive`, plus: small thresholds, also for bodies, replay of late updates, a guess that uses the player's input",
}
PAPERS_THRESHOLDS = ["--threshold", "0.8:0.3", "--body-threshold", "0.1"]


def on_a_bad_network(m):
    return m.sweep("--technique", ",".join(WHAT_THEY_ARE), "--peers", "4", *BAD, "--seeds", SEEDS, "--seconds", ("60", "30"))


def with_papers_thresholds(m):
    return m.sweep("--technique", "full", *PAPERS_THRESHOLDS, "--peers", "4", *BAD, "--seeds", SEEDS, "--seconds", ("60", "30"))


def rows_of(rows, **values):
    chosen = [r for r in rows if all(r[k] == v for k, v in values.items())]
    if not chosen:
        raise Failed(f"no rows with {values}")
    return chosen


def error_and_traffic(rows):
    return [metres(mean(rows, "mean_m")) + " m", f"{mean(rows, 'wire_kbps'):.1f} kbit/s"]


def techniques_in_short(m):
    rows = on_a_bad_network(m)
    lines = []
    for name, what in WHAT_THEY_ARE.items():
        of = rows_of(rows, technique=name)
        shown = f"`{name}`" + (" (default)" if name == "full" else "")
        lines.append([shown, what, *error_and_traffic(of)])
    lines.append(["`full`, 0.8:0.3 m", "the same with the paper's thresholds, and 0.1 m for bodies", *error_and_traffic(with_papers_thresholds(m))])
    return table(["technique", "what it is", "mean inconsistency", "a peer sends"], lines)


def techniques_in_full(m):
    rows = on_a_bad_network(m)
    rows_paper = with_papers_thresholds(m)
    sets = [(f"`--technique {n}`", rows_of(rows, technique=n)) for n in WHAT_THEY_ARE]
    sets.append((f"`--technique full {' '.join(PAPERS_THRESHOLDS)}`", rows_paper))
    lines = []
    for name, of in sets:
        lines.append([
            name, f"{metres(mean(of, 'mean_m'))} ± {metres(interval(of, 'mean_m'))}", metres(mean(of, "avatar_mean_m")),
            metres(mean(of, "body_mean_m")), metres(mean(of, "peak_m")), f"{mean(of, 'wire_kbps'):.1f}",
        ])  # fmt: skip
    return table(["flags", "mean (m)", "avatars", "bodies", "peak", "kbit/s a peer"], lines)


ONE_RUN = ["--peers", "4", "--netem", "delay 100ms 50ms loss 10%", "--seconds", "60", "--seed", "3", "--csv", "-"]


def techniques_over_time(m):
    return "\n".join(m.lab("run", "--technique", name, *ONE_RUN)[0] for name in WHAT_THEY_ARE)


def draw_techniques(m, path):
    """The mean of the peers, averaged over half a second."""
    data = []
    for name in WHAT_THEY_ARE:
        sums = {}
        for row in csv.reader(m.lab("run", "--technique", name, *ONE_RUN)[0].splitlines()[1:]):
            half = int(row[0]) // 30
            total, n = sums.get(half, (0.0, 0))
            sums[half] = (total + float(row[4]), n + 1)
        data.append(f"${name.replace('-', '_')} << EOD\n" +
                    "".join(f"{(k + 0.5) / 2} {s / n}\n" for k, (s, n) in sorted(sums.items())) + "EOD\n")  # fmt: skip
    gnuplot("".join(data) + f"""
set terminal svg size 860,380 font "sans,13" background rgb "white"
set output "{path}"
set logscale y
set yrange [0.01:300]
set grid ytics lc rgb "#dddddd"
set border 3
set tics nomirror
set key outside right center samplen 2
set xlabel "session time (s)"
set ylabel "combined inconsistency (m)"
set title "4 peers, 100 ms +- 50 ms, 10 % loss: how far each view is from the truth, all entities summed"
plot $avatar_only with lines lw 2 lc rgb "#D55E00" title "avatar-only", \\
     $fixed with lines lw 2 lc rgb "#E69F00" title "fixed 0.5 m", \\
     $adaptive with lines lw 2 lc rgb "#0072B2" title "adaptive 0.8:0.3 m", \\
     $full with lines lw 3 lc rgb "#009E73" title "full"
""")


def gnuplot(text):
    done = subprocess.run(["gnuplot"], input=text.encode(), stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        raise Failed("gnuplot: " + done.stderr.decode().strip())


def copied(*words, file):
    """A picture that padr-lab draws itself into its folder."""

    def draw(m, path):
        shutil.copyfile(os.path.join(m.lab(*words)[1], file), path)

    return draw


def one_run(m):
    """What a run prints, but for how fast this machine was."""
    text, _ = m.lab("run", "--scenario", "arena", "--peers", "4", "--netem", "delay 100ms 50ms loss 10%", "--seconds", "60", "--seed", "3")  # fmt: skip
    lines = [line for line in text.splitlines() if "times real time" not in line]
    return "\n".join(("    " + line).rstrip() for line in lines)


def chaos(m):
    text, _ = m.lab("chaos", "--seed", "1", "--runs", ("4", "1"), "--jobs", "1")
    return "\n".join("    " + line for line in text.splitlines())


# --- what is shown

CONVERGENCE = ["convergence", "--netem", "delay 100ms 30ms loss 2%", "--seconds", "60"]


def convergence(m):
    text, _ = m.lab(*CONVERGENCE, "--out", "OUT")
    lines = text.splitlines()
    first = next(i for i, line in enumerate(lines) if line.lstrip().startswith("method")) - 1
    last = next(i for i, line in enumerate(lines) if line.startswith("track"))
    return "\n".join("    " + line for line in lines[first : last + 1])


# --- the paper's experiments

# What the paper's technique is without the warning, and without what PADR tells of bodies at rest.
CONTROLS = ["adaptive --predictor none", *(f"fixed --threshold {t} --rest-state off" for t in ("0.8", "0.5", "0.3"))]
EXPERIMENTS = ["figures", "--seeds", ("24", "1"), "--seconds", ("60", "4"), *(w for c in CONTROLS for w in ("--add", c)), "--no-pictures"]


def experiments_of(m):
    _, folder = m.lab(*EXPERIMENTS, "--out", "OUT")
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        return json.load(file)


def experiments(m):
    summary = experiments_of(m)
    added = {re.sub(r"[^0-9A-Za-z.]", "-", c): c for c in CONTROLS}
    lines = []
    for name, of in summary["means"].items():
        lines.append([
            f"`{added.get(name, name)}`", metres(of["mean_m"]), metres(of["last_third_mean_m"]), metres(of["peak_m"]), metres(of["body_peak_m"]),
            f"{100 * of['free_ticks_within_threshold_share']:.0f} %" if of["free_ticks_within_threshold_share"] is not None else "-", metres(of["fidelity_mean_m"]),
            f"{of['updates_per_min']:.0f}", f"{of['wire_kbps']:.2f}",
        ])  # fmt: skip
    return table(["setting", "mean (m)", "last third", "peak", "bodies' peak", "within the threshold, without contact",
                  "fidelity error (m)", "updates/min", "kbit/s"], lines)  # fmt: skip


DRAWN = ["figures", "--seeds", "6"]


def experiments_over_time(m):
    folder = m.folder("figures", "--seeds", ("6", "1"), "--seconds", ("60", "4"), "--no-pictures")
    with open(os.path.join(folder, "runs.csv"), encoding="utf-8") as file:
        return file.read()


def predictors(m):
    lines = []
    for name, of in experiments_of(m)["predictors"].items():
        lines.append([f"`{name}`", f"{100 * of['precision']:.0f} %", f"{100 * of['recall']:.0f} %", f"{100 * of['warned_share_of_free_time']:.0f} %"])
    return table(["predictor", "warnings right", "contacts foreseen", "of the time without contact warned"], lines)


def claims(m):
    lines = []
    for claim in experiments_of(m)["claims"]:
        verdict = "yes" if claim["holds_on_average"] else "**no**"
        lines.append([claim["figure"], claim["paper"], verdict, f"{claim['holds_in']} of {claim['of']}"])
    return table(["figure", "claim", "on average", "holds in"], lines)


# --- the paper's stories

EXAMPLES = ["examples", "--no-pictures", "--takes", ("8", "2"), "--out", "OUT"]


FILMS = ["examples", "--stories", "ball,dominoes,proxy", "--takes", "1"]


def stories(m):
    results = m.json(*EXAMPLES)["results"]
    names = list(dict.fromkeys(r["story"] for r in results))
    kinds = {"without authority": "avatar-only --threshold 0.8 --predictor none", "`adaptive`": "adaptive --threshold 0.8:0.3 --predictor lookahead",
             "`full`": "full"}  # fmt: skip

    def end(story, technique):
        of = [r for r in results if r["story"] == story and r["technique"] == technique]
        if not of:
            of = [r for r in results if r["story"] == story and r["technique"] == technique.split(" --threshold 0.8:0.3")[0]
                  + technique.partition("--threshold 0.8:0.3")[2]]  # fmt: skip
        if len(of) != 1:
            raise Failed(f"examples has {len(of)} rows of {story}, {technique}")
        return f"{of[0]['pcc_final_m']:.2f} m"

    return table(["story", *kinds], [[name, *(end(name, t) for t in kinds.values())] for name in names])


# --- agreement and truth

CONTESTED = ["avatar-only", "fixed --threshold 0.8", "fixed --threshold 0.5", "fixed --threshold 0.3", "adaptive", "full"]


def agreement_and_truth(m):
    """Of every technique, with unowned bodies of the player's own world and of the agreed one."""
    rows = []
    for unowned in ("live", "agreed"):
        rows += [
            {**r, "unowned": unowned}
            for r in m.sweep("--technique", ",".join(CONTESTED), "--unowned", unowned, "--delay", "0,100ms", "--peers", "2,4",
                             "--seeds", SEEDS, "--seconds", ("30", "4"))  # fmt: skip
        ]
    lines = []
    for peers in ("2", "4"):
        for delay in ("0", "100"):
            for name in CONTESTED:
                for unowned in ("live", "agreed"):
                    if name == "avatar-only" and unowned == "agreed":
                        continue  # every body is everybody's own
                    of = rows_of(rows, peers=peers, delay_ms=delay, technique=name, unowned=unowned)
                    lines.append([
                        peers, f"{delay} ms", f"`{name}`", unowned if name != "avatar-only" else "-",
                        f"{metres(mean(of, 'mean_m'))} ± {metres(interval(of, 'mean_m'))}", metres(mean(of, "body_mean_m")),
                        metres(mean(of, "peak_m")), f"{metres(mean(of, 'fidelity_mean_m'))} ± {metres(interval(of, 'fidelity_mean_m'))}",
                        f"{mean(of, 'wire_kbps'):.1f}",
                    ])  # fmt: skip
    return table(["peers", "delay", "technique", "unowned bodies", "inconsistency (m)", "of it bodies", "peak", "fidelity error (m)",
                  "kbit/s"], lines)  # fmt: skip


# --- against what others do

DELAYS = ["delay 0ms", "delay 50ms", "delay 100ms", "delay 250ms"]
# Those that know of authority; rivals.py has those that send inputs alone.
AUTHORITY = "paper,ours,ablations,snapshot-10,snapshot-20,snapshot-60,state-sync-5,state-sync-8,state-sync-10,state-sync-20,state-sync-60,dis,dis-0.3m"
COMPARED = ["compare", "--techniques", AUTHORITY, "--seeds", ("40", "1"), "--seconds", ("30", "3")]


def compared(m):
    rows = m.json(*COMPARED)["rows"]
    names = list(dict.fromkeys(r["technique"] for r in rows))
    lines = []
    for name in names:
        cells = []
        for delay in DELAYS:
            of = next(r for r in rows if r["technique"] == name and r["netem"] == delay)
            cells.append(f"{metres(of['mean_m']['mean'])} / {metres(of['peak_m']['mean'])} / {metres(of['fidelity_mean_m']['mean'])}, "
                         f"{of['kbit_per_s']['mean']:.0f}")  # fmt: skip
        lines.append([f"`{name}`", *cells])
    return table(["technique", *("no delay" if d == "delay 0ms" else d[6:] for d in DELAYS)], lines)


LOSSY = "frontier_delay_100ms_50ms_loss_10_"

FIGURES = [
    Figure("techniques", "README.md", techniques_in_short),
    Figure("bad-network", "docs/lab.md", techniques_in_full),
    Figure("one-run", "docs/lab.md", one_run),
    Figure("convergence", "docs/lab.md", convergence),
    Figure("chaos", "docs/sessions.md", chaos),
    Figure("experiments", "docs/experiments.md", experiments),
    Figure("predictors", "docs/experiments.md", predictors),
    Figure("claims", "docs/experiments.md", claims),
    Figure("stories", "docs/experiments.md", stories),
    Figure("agreement", "docs/experiments.md", agreement_and_truth),
    Figure("compared", "docs/compare.md", compared),
    Picture("techniques", techniques_over_time, draw_techniques),
    Picture("figures", experiments_over_time, copied(*DRAWN, "--out", "OUT", file="drift.svg")),
    Picture("film-ball", stories, copied(*FILMS, "--out", "OUT", file="film-ball.svg")),
    Picture("film-dominoes", stories, copied(*FILMS, "--out", "OUT", file="film-dominoes.svg")),
    Picture("film-proxy", stories, copied(*FILMS, "--out", "OUT", file="film-proxy.svg")),
    Figure("rivals", "docs/compare.md", rivals.briefly),
    Figure("budgets", "docs/compare.md", rivals.budgets),
    Figure("met", "docs/compare.md", rivals.met),
    Figure("elsewhere", "docs/compare.md", rivals.elsewhere),
    Picture("compare", rivals.data_of("frontier_delay_100ms"), rivals.drawn("frontier_delay_100ms")),
    Picture("compare-hands", rivals.data_of("hands_delay_100ms"), rivals.drawn("hands_delay_100ms")),
    Picture("compare-loss", rivals.data_of(LOSSY), rivals.drawn(LOSSY)),
    Picture("film-convergence", convergence, copied(*CONVERGENCE, "--out", "OUT", file="film-convergence.svg")),
]
