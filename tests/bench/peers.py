#!/usr/bin/env python3
"""The cost of real peers: processes of padr-peer over UDP on this machine, in sessions of doubling size.

Usage: peers.py PADR_PEER_COUNTED PADR_BENCH [--peers 4,8,16,32,64] [--seconds S] [--warm-up S] [--scenario NAME] [--input INPUT]
                [--paths FOLDER] [--json FILE] [--no-strace]

Each row is a session of so many peers, from its first tick to its last:

  cpu %       of one core, that a peer takes: processor time of all of them while all play, by peers and seconds
  frames      that processor time per tick as a multiple of what padr-bench takes in the same run for the frame of such a
              peer (frame/quiet: all nodes in one process on a virtual network); "-" unless everybody rests
  syscalls/s  of one peer, counted by strace for two seconds after all else was measured; "-" where there is no strace
  allocs/s    of one peer in the mean: padr-peer-counted counts its own
  late %      of all ticks, begun more than a tick (16.7 ms) after their time
  median, p99, worst   how late ticks began, ms: of the peer in the middle, of the worst peer, of all
  load        of the machine before, by what else runs on it: late ticks are its as well

Measuring begins --warm-up seconds after the session's start; after 20 s all that is kept for a time has been.

The last line is the greatest number of peers of which no tick was late, by core. --paths: peers follow the *.csv in that
folder, one each, in turn. The output is the same as JSON with --json.

Exit status: 0 when all was measured and all confirmed worlds were alike, 1 if not, 2 for wrong arguments.
"""

import argparse
import glob
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

TICKS_PER_SECOND = 60
STRACE = 2.0  # s
PATIENCE = 60.0  # s until something that should happen counts as missing


class Session:
    """So many processes that play, with their files in a folder."""

    def __init__(self, options, count, folder):
        self.options = options
        self.folder = folder
        self.processes = []
        paths = sorted(glob.glob(os.path.join(options.paths, "*.csv"))) if options.paths else []
        self.inputs = [f"path:{paths[n % len(paths)]},loop" if paths else options.input for n in range(count)]

    def file(self, number, kind):
        return os.path.join(self.folder, f"{number}.{kind}")

    def start(self, *role):
        number = len(self.processes)
        with open(self.file(number, "log"), "wb") as log:
            self.processes.append(subprocess.Popen(
                [self.options.peer, "--scenario", self.options.scenario, "--input", self.inputs[number], "--status-interval", "0",
                 "--json", self.file(number, "json"), *role],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
                env={**os.environ, "PADR_ALLOCATIONS": self.file(number, "allocations")}))  # fmt: skip

    def wait_for(self, number, pattern):
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline and self.processes[number].poll() is None:
            with open(self.file(number, "log"), encoding="utf-8", errors="replace") as log:
                found = re.search(pattern, log.read())
            if found:
                return found
            time.sleep(0.05)
        raise RuntimeError(f"peer {number} has not said {pattern!r}; its log is {self.file(number, 'log')}")

    def gather(self):
        count = len(self.inputs)
        self.start("--listen", "127.0.0.1:0", "--wait-peers", str(count), "--slots", str(count))
        port = self.wait_for(0, r"listening on \S+:(\d+)")[1]
        for _ in range(1, count):
            self.start("--join", f"127.0.0.1:{port}")
        lead = float(self.wait_for(0, r"peers? starts in ([\d.]+) s")[1])
        time.sleep(lead + self.options.warm_up)

    def processor_seconds(self):
        total = 0
        for process in self.processes:
            with open(f"/proc/{process.pid}/schedstat", encoding="ascii") as file:
                total += int(file.read().split()[0])
        return total * 1e-9

    def allocations(self):
        total = 0
        for number in range(len(self.processes)):
            with open(self.file(number, "allocations"), "rb") as file:
                total += int.from_bytes(file.read(8), sys.byteorder)
        return total

    def end(self):
        for process in self.processes:
            process.send_signal(signal.SIGINT)
        codes = [process.wait(PATIENCE) for process in self.processes]
        if any(codes):
            raise RuntimeError(f"peers ended with {codes}; their logs are in {self.folder}")
        summaries = []
        for number in range(len(self.processes)):
            with open(self.file(number, "json"), encoding="utf-8") as file:
                summaries.append(json.load(file))
        return summaries

    def stop(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
                process.wait()


def syscalls(pid):
    """Of a process, by strace; None without it, or where it may not look."""
    strace = shutil.which("strace")
    if not strace:
        return None
    begun = time.monotonic()
    with subprocess.Popen([strace, "-f", "-c", "-p", str(pid)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as trace:
        time.sleep(STRACE)
        trace.send_signal(signal.SIGINT)
        _, text = trace.communicate(timeout=PATIENCE)
    # % time, seconds, usecs/call, calls, ... for each call of the system.
    rows = [line.split() for line in text.splitlines() if re.match(r"\s*\d+\.\d+\s", line) and not line.endswith("total")]
    return sum(int(row[3]) for row in rows) / (time.monotonic() - begun) if rows else None


def check_agreement(summaries):
    values = {}
    for summary in summaries:
        for tick, value in summary["confirmed"]["checkpoints"].items():
            values.setdefault(tick, set()).add(value)
    differing = sorted(int(tick) for tick, hashes in values.items() if len(hashes) > 1)
    if differing or not values:
        raise RuntimeError(f"confirmed worlds differ at ticks {differing[:5]}" if differing else "nothing was confirmed")


def measure(options, count):
    load = os.getloadavg()[0]
    folder = tempfile.mkdtemp(prefix="padr-peers-")
    session = Session(options, count, folder)
    try:
        session.gather()
        begun, cpu, allocations = time.monotonic(), session.processor_seconds(), session.allocations()
        time.sleep(options.seconds)
        seconds = time.monotonic() - begun
        cpu, allocations = session.processor_seconds() - cpu, session.allocations() - allocations
        traced = None if options.no_strace else syscalls(session.processes[-1].pid)
        summaries = session.end()
    finally:
        session.stop()
    check_agreement(summaries)
    shutil.rmtree(folder)
    if traced is not None:
        summaries.pop()  # strace has made that one late
    ticks = sum(s["ticks"] - s["first_tick"] for s in summaries)
    late = sum(s["late_ticks"] for s in summaries)
    return {
        "peers": count, "seconds": seconds, "cpu_share": cpu / seconds / count, "us_per_tick": cpu / seconds / count / TICKS_PER_SECOND * 1e6,
        "syscalls_per_s": traced, "allocs_per_s": allocations / seconds / count, "ticks": ticks, "late_ticks": late, "late_share": late / ticks,
        "median_late_ms": sorted(s["median_late_ms"] for s in summaries)[len(summaries) // 2],
        "p99_late_ms": max(s["p99_late_ms"] for s in summaries), "worst_late_ms": max(s["worst_late_ms"] for s in summaries), "load": load,
    }  # fmt: skip


def frames(options, counts):
    """Microseconds of a frame of padr-bench by the number of peers."""
    if options.input != "rest" or options.paths or options.scenario != "arena":
        return {}
    names = "|".join(str(n) for n in counts)
    done = subprocess.run([options.bench, f"--benchmark_filter=^frame/quiet/bodies:60/peers:({names})/", "--benchmark_format=json"],
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True)  # fmt: skip
    rows = json.loads(done.stdout)["benchmarks"] if done.stdout.strip() else []
    return {int(re.search(r"peers:(\d+)", row["name"])[1]): row["frame_us"] for row in rows}


COLUMNS = [("peers", "peers", "d", 1), ("cpu_share", "cpu %", ".2f", 100), ("frames", "frames", ".2f", 1),
           ("syscalls_per_s", "syscalls/s", ".0f", 1), ("allocs_per_s", "allocs/s", ".0f", 1), ("late_share", "late %", ".3f", 100),
           ("median_late_ms", "median", ".2f", 1), ("p99_late_ms", "p99", ".2f", 1), ("worst_late_ms", "worst", ".1f", 1),
           ("load", "load", ".1f", 1)]  # fmt: skip


def table(rows):
    lines = [[title for _, title, _, _ in COLUMNS]]
    lines += [["-" if row[key] is None else format(row[key] * scale, style) for key, _, style, scale in COLUMNS] for row in rows]
    widths = [max(len(line[n]) for line in lines) for n in range(len(COLUMNS))]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(line, widths)) for line in lines)


def run(options):
    counts = [int(n) for n in options.peers.split(",")]
    bench = frames(options, counts)
    rows = []
    for count in counts:
        row = measure(options, count)
        row["frames"] = row["us_per_tick"] / bench[count] if count in bench else None
        rows.append(row)
        print(f"  {count} peers: {100 * row['late_share']:.3f} % of {row['ticks']} ticks late", file=sys.stderr, flush=True)
    well = [row["peers"] for row in rows if row["late_ticks"] == 0]
    cores = len(os.sched_getaffinity(0))
    result = {"scenario": options.scenario, "input": options.paths or options.input, "cores": cores, "rows": rows,
              "peers_per_core_without_late_ticks": max(well, default=0) / cores}  # fmt: skip
    print(f"peers {options.scenario} {result['input']}")
    print(table(rows))
    print(f"peers per core without a late tick: {result['peers_per_core_without_late_ticks']:g}, of {cores} cores")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(result, file, indent=1)


def parse(arguments):
    p = argparse.ArgumentParser(prog="peers.py", usage=__doc__.replace("%", "%%"))
    p.add_argument("peer")
    p.add_argument("bench")
    p.add_argument("--peers", default="4,8,16,32,64")
    p.add_argument("--seconds", type=float, default=8)
    p.add_argument("--warm-up", type=float, default=2)
    p.add_argument("--scenario", default="arena")
    p.add_argument("--input", default="rest")
    p.add_argument("--paths")
    p.add_argument("--json")
    p.add_argument("--no-strace", action="store_true")
    return p.parse_args(arguments)


if __name__ == "__main__":
    try:
        run(parse(sys.argv[1:]))
    except RuntimeError as error:
        sys.exit(f"peers.py: {error}")
