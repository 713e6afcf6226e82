#!/usr/bin/env bash
# Every fuzz target for as long as one likes; corpora grow from one run to the next, and findings are kept.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/fuzz.sh [options] [TARGET...]

Builds the fuzz targets with clang, ASan and UBSan, and runs them one after another, or those that are named
(tests/fuzz; --list tells them). Prints a row for each: executions, executions a second, edges covered, inputs kept.

  --minutes N   in all, shared out evenly, 1 to 10000    (default 10)
  --out DIR     corpora and findings                     (default out/fuzz)
  --list        only say which targets there are
  --help        this text

DIR/corpus/TARGET has the inputs that reach something new, DIR/findings what crashed, leaked or took too long, DIR/logs
what libFuzzer says. A finding is tried again by: build/fuzz/bin/fuzz_TARGET FINDING
PADR_JOBS=N in the environment bounds the parallel build jobs.

Exit status: 0 when nothing was found; 1 when something was, or cannot be built; 2 for wrong arguments.
TEXT
}

fail_usage() { echo "fuzz.sh: $1 (see --help)" >&2; exit 2; }

minutes=10
out=
list=no
targets=()
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --list) list=yes ;;
    --minutes=* | --out=*) set -- "${1%%=*}" "${1#*=}" "${@:2}"; continue ;;
    --minutes | --out)
      (($# > 1)) || fail_usage "$1 needs a value"
      if [[ $1 == --minutes ]]; then minutes=$2; shift 2; continue; fi
      if [[ -z $2 ]]; then fail_usage "--out must not be empty"; fi
      out=$(realpath -m -- "$2")
      if [[ -e $out && ! -d $out ]]; then fail_usage "--out '$2' is no directory"; fi
      shift ;;
    -*) fail_usage "unknown option '$1'" ;;
    *) targets+=("$1") ;;
  esac
  shift
done
if [[ ! $minutes =~ ^[1-9][0-9]{0,4}$ ]] || ((minutes > 10000)); then
  fail_usage "--minutes: '$minutes' is not from 1 to 10000"
fi

cd "$(dirname "$0")/.."
out=${out:-out/fuzz}
mapfile -t all < <(sed -n 's/^padr_fuzz(\([a-z_]*\).*/\1/p' tests/fuzz/CMakeLists.txt)
if [[ $list == yes ]]; then printf '%s\n' "${all[@]}"; exit 0; fi
if ((${#targets[@]} == 0)); then targets=("${all[@]}"); fi
for target in "${targets[@]}"; do
  [[ " ${all[*]} " == *" $target "* ]] || fail_usage "there is no target '$target'; there are: ${all[*]}"
done

tools/deps.sh build test check
clang=$(compgen -c clang++ | grep -E '^clang\+\+(-[0-9]+)?$' | sort -V | tail -n 1 || true)
if [[ -z $clang ]]; then echo "fuzz.sh: no clang++ here" >&2; exit 1; fi
cmake --preset fuzz -DCMAKE_CXX_COMPILER="$clang" -DPADR_TEST_SUITES=fuzz >/dev/null
cmake --build --preset fuzz --parallel "${PADR_JOBS:-$(nproc)}" --target "${targets[@]/#/fuzz_}"

mkdir -p "$out/findings" "$out/logs"
seconds=$((minutes * 60 / ${#targets[@]}))
if ((seconds < 1)); then seconds=1; fi
found=0
printf '%-12s %14s %10s %8s %8s\n' target executions per_second edges kept
for target in "${targets[@]}"; do
  corpus=$out/corpus/$target
  log=$out/logs/$target.log
  mkdir -p "$corpus"
  status=0
  "build/fuzz/bin/fuzz_$target" -max_total_time="$seconds" -max_len=8192 -timeout=60 -print_final_stats=1 \
    -artifact_prefix="$out/findings/$target-" "$corpus" >"$log" 2>&1 || status=$?
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$log")
  edges=$(sed -n 's/.*cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)
  printf '%-12s %14s %10s %8s %8s' "$target" "${runs:--}" "${rate:--}" "${edges:--}" \
    "$(find "$corpus" -type f | wc -l)"
  if ((status != 0)); then
    found=1
    printf '  FOUND: %s' "$(grep -m 1 -E '^(SUMMARY|.*ERROR)' "$log" || echo "exit status $status")"
  fi
  printf '\n'
done
if ((found != 0)); then echo "findings: $out/findings, logs: $out/logs" >&2; fi
exit "$found"
