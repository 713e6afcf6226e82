#!/usr/bin/env bash
# The benchmarks, as a table and as JSON: every figure stands beside something measured in the same run.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/bench.sh [options] [FILTER]

Builds padr-bench (preset release) and runs it; FILTER is a regular expression of names, all without it. For each group
prints a table, whose columns the first lines of tests/bench/*_bench.cpp explain, and writes everything as JSON.
Times are processor time of one thread, so that a loaded machine spoils them little; ratios are what counts.

The group "peers" is real processes instead, by themselves: FILTER must be that word. It runs sessions of 4 to 64 peers at
rest and tells what a peer costs and how many of them a core carries; the first lines of tests/bench/peers.py explain the
columns. Late ticks are wall time, and so anything else that runs on the machine counts.

  --json FILE   where the JSON goes   (default out/bench/bench.json, of peers out/bench/peers.json)
  --list        only say which benchmarks there are
  --help        this text

PADR_JOBS=N in the environment bounds the parallel build jobs.

Exit status: 0 when all were measured; 1 when something cannot be built or measured; 2 for wrong arguments.
TEXT
}

fail_usage() { echo "bench.sh: $1 (see --help)" >&2; exit 2; }

json=
set_json() { # FILE
  if [[ -z $1 ]]; then fail_usage "--json must not be empty"; fi
  json=$(realpath -m -- "$1")
  if [[ -d $json ]]; then fail_usage "--json '$1' is a directory; name a file"; fi
}
list=no
filter=
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --list) list=yes ;;
    --json=*) set_json "${1#*=}" ;;
    --json) (($# > 1)) || fail_usage "--json needs a file"; set_json "$2"; shift ;;
    -*) fail_usage "unknown option '$1'" ;;
    *) [[ -z $filter ]] || fail_usage "one FILTER, not '$filter' and '$1'"; filter=$1 ;;
  esac
  shift
done

cd "$(dirname "$0")/.."
peers=no
if [[ $filter == peers ]]; then peers=yes; fi
if [[ $peers == yes ]]; then json=${json:-$PWD/out/bench/peers.json}; fi
json=${json:-$PWD/out/bench/bench.json}
mkdir -p "$(dirname "$json")"
tools/deps.sh build test
cmake --preset release -DPADR_TESTS=ON >/dev/null
cmake --build build/release --parallel "${PADR_JOBS:-$(nproc)}" --target padr-bench padr-peer-counted
if [[ $list == yes ]]; then
  build/release/bin/padr-bench --benchmark_list_tests
  echo peers
  exit 0
fi
if [[ $peers == yes ]]; then
  python3 -B tests/bench/peers.py build/release/bin/padr-peer-counted build/release/bin/padr-bench --json "$json"
  echo
  echo "all of it: $json"
  exit 0
fi

if [[ -z $(build/release/bin/padr-bench --benchmark_list_tests --benchmark_filter="${filter:-.}") ]]; then
  fail_usage "no benchmark is named like '$filter'; --list tells them"
fi
build/release/bin/padr-bench --benchmark_filter="${filter:-.}" --benchmark_out="$json" --benchmark_out_format=json >/dev/null
python3 - "$json" <<'PYTHON'
import json
import sys

OF_THE_LIBRARY = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
                  "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit"}  # fmt: skip
with open(sys.argv[1], encoding="utf-8") as f:
    rows = json.load(f)["benchmarks"]
groups = {}
failed = False
for row in rows:
    parts = [p for p in row["name"].split("/") if not p.startswith("iterations:")]
    groups.setdefault(parts[0], []).append((" ".join(parts[1:]), row))
for group, members in groups.items():
    columns = sorted({c for _, row in members for c in row} - OF_THE_LIBRARY - {"error_occurred", "error_message"})
    table = [[group, *columns]]
    for name, row in members:
        if row.get("error_occurred"):
            failed = True
            print(f"{group} {name}: {row['error_message']}", file=sys.stderr)
            continue
        table.append([name or "-", *(f"{row[c]:.4g}" if c in row else "-" for c in columns)])
    widths = [max(len(line[i]) for line in table) for i in range(len(columns) + 1)]
    print()
    for line in table:
        print("  ".join([line[0].ljust(widths[0]), *(v.rjust(w) for v, w in zip(line[1:], widths[1:]))]))
sys.exit(1 if failed else 0)
PYTHON
echo
echo "all of it: $json"
