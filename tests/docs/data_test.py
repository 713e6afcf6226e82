#!/usr/bin/env python3
"""docs/data.md against what the programs write: every column and every field, both ways.

usage: data_test.py FOLDER-OF-PROGRAMS

Prints one line per difference and exits 1 if there are any.
"""

import glob
import json
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

import data_page
import documents  # noqa: F401  makes tools/docs known
import pages

PATIENCE = 120  # s; a loaded machine is slow
NETEM = "delay 40ms 10ms loss 10%"


class Programs:
    """Runs the programs in a folder of its own; what they write is there."""

    def __init__(self, folder, out):
        self.folder, self.out, self.running = folder, out, []

    def file(self, name):
        return os.path.join(self.out, name)

    def start(self, program, *arguments, stdout=subprocess.DEVNULL):
        self.running.append(subprocess.Popen([os.path.join(self.folder, program), *arguments], cwd=self.out, text=True,
                                             stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.DEVNULL))  # fmt: skip
        return self.running[-1]

    def run(self, program, *arguments):
        status = self.start(program, *arguments).wait(PATIENCE)
        if status != 0:
            sys.exit(f"data_test.py: {program} {' '.join(arguments)} ended with {status}")

    def stop(self):
        for process in self.running:
            process.kill()
            process.wait()


def lab(p):
    p.run("padr-lab", "run", "--peers", "4", "--seconds", "8", "--netem", NETEM, "--json", "run.json", "--csv", "run.csv",
          "--trace", "traces")
    p.run("padr-lab", "sweep", "--seconds", "2", "--threshold", "0.8,0.3:0.1", "--csv", "sweep.csv", "--summary", "means.csv")
    p.run("padr-lab", "compare", "--seeds", "1", "--seconds", "2", "--techniques", "full,dis", "--netem", NETEM, "--out", "compare")
    p.run("padr-lab", "benchmark", "--seeds", "1", "--seconds", "2", "--techniques", "full,rollback-2", "--netem", NETEM, "--out", "benchmark")
    p.run("padr-lab", "figures", "--seeds", "1", "--seconds", "3", "--out", "figures")
    p.run("padr-lab", "examples", "--takes", "1", "--stories", "dominoes", "--out", "examples", "--json", "examples.json")
    p.run("padr-lab", "convergence", "--seconds", "2", "--out", "convergence")
    p.run("padr-lab", "chaos", "--minutes", "0.2", "--liar", "none", "--json", "chaos.json")
    p.run("padr-lab", "audit", *sorted(glob.glob(os.path.join(p.out, "traces", "*"))), "--json", "audit.json")
    p.run("padr-lab", "crowd", "--peers", "3", "--seconds", "2", "--warm-up", "2", "--json", "crowd.json")
    p.run("padr-lab", "path", "--input", "wander", "--seconds", "2", "--out", "path.csv")
    p.run("padr-report", *glob.glob(os.path.join(p.out, "traces", "*")), "--json", "report.json", "--csv", "report")


def session(page):
    return json.load(urllib.request.urlopen(f"http://{page}/api/session", timeout=PATIENCE))


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def health_of(p, peer):
    """Waits until the peer plays, and keeps its health, which it removes when it ends."""
    while peer.poll() is None:
        try:
            with open(p.file("health"), encoding="utf-8") as file:
                text = file.read()
            if json.loads(text)["playing"]:
                with open(p.file("health.json"), "w", encoding="utf-8") as file:
                    file.write(text)
                return
        except FileNotFoundError:
            pass
        time.sleep(0.05)
    sys.exit("data_test.py: a peer ended before it played")


def live(p):
    """Two peers with a key, and a monitor that looks on; all ports are free ones."""
    monitor = p.start("padr-monitor", "--listen", "127.0.0.1:0", "--peers-listen", "127.0.0.1:0", "--duration", "600",
                      stdout=subprocess.PIPE)  # fmt: skip
    page = re.search(r"127\.0\.0\.1:\d+", monitor.stdout.readline())[0]
    p.run("padr-peer", "keygen", "key")
    place = f"127.0.0.1:{free_port()}"
    common = ["--key-file", "key", "--duration", "5", "--linger", "1", "--netem", NETEM,
              "--monitor", session(page)["hello"]["source"]]  # fmt: skip
    first = p.start("padr-peer", "--listen", place, "--wait-peers", "2", "--health", "health", "--json", "peer.json",
                    "--pcap", "p0.pcapng", "--trace", "p0.trace", *common)  # fmt: skip
    second = p.start("padr-peer", "--join", place, "--trace", "p1.trace", *common)
    p.start("padr-peer", "--crowd", "--listen", "127.0.0.1:0", "--duration", "3", "--json", "peer-crowd.json")
    health_of(p, first)
    while session(page)["scene"] is None:
        time.sleep(0.05)
    with urllib.request.urlopen(f"http://{page}/metrics", timeout=PATIENCE) as answer, open(p.file("of.metrics"), "wb") as file:
        file.write(answer.read())
    for peer in (first, second, *p.running):
        if peer is not monitor and peer.wait(PATIENCE) != 0:
            sys.exit(f"data_test.py: a peer ended with {peer.returncode}")


def captures(p):
    p.run("padr-capture", "summary", "p0.pcapng", "--json", "summary.json")
    p.run("padr-capture", "timeline", "p0.pcapng", "--csv", "timeline.csv", "--json", "timeline.json")
    p.run("padr-capture", "rebuild", "p0.pcapng", "--csv", "rebuild.csv", "--json", "rebuild.json")
    p.run("padr-capture", "compare", "p0.pcapng", "p0.trace", "p1.trace", "--json", "capture-compare.json")
    p.run("padr-capture", "export", "p0.pcapng", "--csv", "--out", "export.csv")


# Which file shows what a heading of the page says; '*' is any name.
FILES = {
    "padr-lab run --json": "run.json",
    "padr-lab run --csv": "run.csv",
    "padr-lab sweep --csv": "sweep.csv",
    "padr-lab sweep --summary": "means.csv",
    "padr-lab compare --csv": "compare/compare.csv",
    "padr-lab compare --json": "compare/compare.json",
    "padr-lab benchmark: results.csv": "benchmark/results.csv",
    "padr-lab figures: runs.csv": "figures/runs.csv",
    "padr-lab figures: predictors.csv": "figures/predictors.csv",
    "padr-lab figures: series-CASE.csv": "figures/series-*.csv",
    "padr-lab figures: summary.json": "figures/summary.json",
    "padr-lab examples: examples.csv": "examples/examples.csv",
    "padr-lab examples: takes.csv": "examples/takes.csv",
    "padr-lab examples: predictors.csv": "examples/predictors.csv",
    "padr-lab examples: summary.json": "examples.json",
    "padr-lab convergence: convergence.csv": "convergence/convergence.csv",
    "padr-lab chaos --json": "chaos.json",
    "padr-lab audit --json": "audit.json",
    "padr-lab crowd --json": "crowd.json",
    "Paths: path-STORY.csv, padr-lab path --out": "path.csv",
    "Pictures of curves: figure7-CASE.csv to figure9-CASE.csv, drift.csv, dominoes.csv": "figures/drift.csv",
    "Pictures of points: peaks.csv, frontier_NETWORK.csv, hands_NETWORK.csv, ablations_NETWORK.csv": "figures/peaks.csv",
    "Pictures of bars: prediction.csv": "figures/prediction.csv",
    "The path: figure6-CASE.csv": "figures/figure6-*.csv",
    "padr-report --json": "report.json",
    "padr-report --csv: inconsistency.csv": "report/inconsistency.csv",
    "padr-report --csv: fidelity.csv": "report/fidelity.csv",
    "padr-report --csv: traffic.csv": "report/traffic.csv",
    "padr-report --csv: links.csv": "report/links.csv",
    "padr-report --csv: authority.csv": "report/authority.csv",
    "padr-peer --json": "peer.json",
    "padr-peer --crowd --json": "peer-crowd.json",
    "padr-peer --health": "health.json",
    "padr-capture summary --json": "summary.json",
    "padr-capture timeline --csv": "timeline.csv",
    "padr-capture timeline --json": "timeline.json",
    "padr-capture rebuild --csv": "rebuild.csv",
    "padr-capture rebuild --json": "rebuild.json",
    "padr-capture compare --json": "capture-compare.json",
    "/metrics": "of.metrics",
}


def complaints(tables, out):
    """What differs between the page and the files, and files of a kind that the page does not know."""
    used, known = set(), {os.path.join(out, "export.csv")}
    for heading, pattern in FILES.items():
        if heading not in tables:
            yield f"there is no table under the heading '{heading}'"
            continue
        rows, groups = data_page.rows_of(tables, heading)
        used |= groups | {heading}
        for file in glob.glob(os.path.join(out, pattern)):
            known.add(file)
            yield from (f"{heading}: {what}" for what in data_page.differences(rows, data_page.names_in(file)))
    for heading in tables:
        if heading not in used and heading != "Words in capitals":
            yield f"'{heading}' is about no file that the test knows"
    drawn = re.compile(r"(figure[789]-.*|dominoes|drift|frontier_.*|hands_.*|ablations_.*|path-.*|seed\d+-peer\d+|results|summary|examples)\.(csv|json)$")
    for file in glob.glob(os.path.join(out, "**", "*.*"), recursive=True):
        if file.endswith((".csv", ".json")) and file not in known and not drawn.match(os.path.basename(file)):
            yield f"the page says nothing of {os.path.basename(file)}"


def export_complaints(out):
    page = pages.read("docs/reference-fields.md")
    told = set(re.findall(r"^\| `([^`]+)`.*\| (?:yes|list) \|", page, re.M))
    for name in data_page.names_in(os.path.join(out, "export.csv")):
        if name not in told and f"`{name}`" not in page:
            yield f"docs/reference-fields.md does not name {name}"


def main(arguments):
    if len(arguments) != 1:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as out:
        p = Programs(os.path.abspath(arguments[0]), out)
        try:
            live(p)
            captures(p)
            lab(p)
        finally:
            p.stop()
        found = list(complaints(data_page.sections(pages.read("docs/data.md")), out)) + list(export_complaints(out))
    print("\n".join(found) if found else f"{len(FILES)} files: every column and field is on docs/data.md")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
