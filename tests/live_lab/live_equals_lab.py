#!/usr/bin/env python3
"""Four real peers over real UDP; each trace replays to identical hashes, the confirmed worlds of the four agree, and the
report's figures are close to those of the lab's run with the same inputs and shim seeds.

They cannot be equal: real datagrams leave and arrive between ticks, so they meet other random numbers of the shims and are
applied a tick earlier or later. The bounds below are for that, on a run of a few seconds.

Usage: live_equals_lab.py PADR_PEER PADR_LAB PADR_REPORT
"""

import json
import os
import re
import subprocess
import sys
import tempfile

PEER, LAB, REPORT = sys.argv[1:4]
PEERS = 4
SECONDS = 15
NETEM = "delay 100ms 50ms loss 10%"
SEED = 11
COMMON = ["--scenario", "arena", "--seed", str(SEED), "--netem", NETEM, "--netem-seed", str(SEED),
          "--technique", "full", "--threshold", "0.3:0.1", "--body-threshold", "0.05"]  # fmt: skip


def play(folder):
    """The peers' traces, in the order of their numbers."""
    flags = [*COMMON, "--input", "wander", "--duration", str(SECONDS), "--linger", "8"]
    log = open(os.path.join(folder, "0.log"), "w+")
    traces = [os.path.join(folder, f"{i}.trace") for i in range(PEERS)]
    peers = [subprocess.Popen([PEER, "--listen", "127.0.0.1:0", "--wait-peers", str(PEERS), *flags, "--trace", traces[0]],
                              stderr=log)]  # fmt: skip
    port = None
    while port is None:
        assert peers[0].poll() is None, open(log.name).read()
        found = re.search(r"listening on 127\.0\.0\.1:(\d+)", open(log.name).read())
        port = found and found.group(1)
    for i in range(1, PEERS):
        own = open(os.path.join(folder, f"{i}.log"), "w")
        peers.append(subprocess.Popen([PEER, "--join", f"127.0.0.1:{port}", *flags, "--trace", traces[i]], stderr=own))
    codes = [p.wait(timeout=SECONDS + 60) for p in peers]
    for i, code in enumerate(codes):
        assert code == 0, f"peer {i} ended with {code}:\n" + open(os.path.join(folder, f"{i}.log")).read()
    return traces


def main():
    with tempfile.TemporaryDirectory() as folder:
        traces = play(folder)
        for trace in traces:
            verdict = subprocess.run([LAB, "replay", trace], capture_output=True, text=True)
            print(verdict.stdout.strip().replace(folder + os.sep, ""))
            assert verdict.returncode == 0 and "identical" in verdict.stdout, verdict.stdout + verdict.stderr
        report = subprocess.run([REPORT, *traces, "--json", "-"], capture_output=True, text=True)
        assert report.returncode == 0, report.stdout + report.stderr
        live = json.loads(report.stdout)
        twin = subprocess.run([LAB, "run", *COMMON, "--input", "wander", "--peers", str(PEERS), "--seconds", str(SECONDS),
                               "--json", "-"], capture_output=True, text=True, check=True)  # fmt: skip
        lab = json.loads(twin.stdout)

    assert live["confirmed_mismatches"] == 0 and lab["confirmed_mismatches"] == 0
    assert live["confirmed_ticks"] >= SECONDS * 60, live["confirmed_ticks"]
    # Players' deeds and what they cost are measured from traces of real peers as in the lab.
    for name in ("fidelity_mean_m", "fidelity_own_mean_m", "fidelity_others_mean_m", "fidelity_peak_m"):
        print(f"{name:24} live {live[name]:8.3f}  lab {lab[name]:8.3f}")
    assert 0 < live["fidelity_mean_m"] < 5 * lab["fidelity_mean_m"], live["fidelity_mean_m"]
    assert sum(p["deeds"] for p in live["by_peer"]) > 0 and all("pcc_mean_m" in p for p in live["by_peer"])
    close = True
    for name, factor in [("mean_m", 2.0), ("avatar_mean_m", 2.0), ("updates_per_s", 2.0), ("wire_kbps", 1.6),
                         ("datagrams_per_s", 1.5)]:  # fmt: skip
        a, b = live[name], lab[name]
        within = a < factor * b and b < factor * a
        close = close and within
        print(f"{name:16} live {a:8.3f}  lab {b:8.3f}  {'' if within else f'NOT within a factor of {factor}'}")
    return 0 if close else 1


if __name__ == "__main__":
    sys.exit(main())
