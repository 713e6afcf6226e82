#!/usr/bin/env bash
# Builds the release preset with its tests and runs them, installing what is missing first.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/test.sh [--help] [CTEST-ARGUMENT...]

Installs missing packages (tools/deps.sh), configures and builds preset `release` with the tests, runs them.
Further arguments go to ctest, for example:

  tools/test.sh -R architecture     only tests whose name matches
  tools/test.sh -L lab              only tests that carry a label
  tools/test.sh --rerun-failed

PADR_JOBS=N in the environment bounds the parallel jobs (default: the processors of this machine).
TEXT
}
for arg in "$@"; do
  case $arg in --help | -h) usage; exit 0 ;; esac
done

cd "$(dirname "$0")/.."
jobs=${PADR_JOBS:-$(nproc)}
if ! [[ $jobs =~ ^[1-9][0-9]*$ ]]; then echo "test.sh: PADR_JOBS is '$jobs', must be a number from 1" >&2; exit 2; fi

# What has to be compiled is preprocessed once and not twice.
export CCACHE_DEPEND=1
# Tests draw pictures, too.
tools/deps.sh build run test
log=$(mktemp)
trap 'rm -f "$log" "$log.skipped"' EXIT
echo "== configuring build/release"
if ! cmake --preset release -DPADR_TESTS=ON >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
echo "== building"
cmake --build build/release --parallel "$jobs"
echo "== testing"
# Several tests are real processes that wait more than they compute: tests/CMakeLists.txt says how many run at once.
ctest --test-dir build/release --output-on-failure --no-tests=error --parallel $((jobs + 6)) "$@" | tee "$log" &&
  status=0 || status=$?

# Which tests were skipped, and the first thing that each of them said about it.
sed -n 's/^[[:space:]]*[0-9]* - \(.*\) (Skipped)$/\1/p' "$log" | sort -u >"$log.skipped"
if [[ -s $log.skipped ]]; then
  awk '
    FILENAME == ARGV[1] { skipped[$0] = 1; next }
    / Testing: / { name = $0; sub(/.* Testing: /, "", name); why = "" }
    why == "" && tolower($0) ~ /^skipped: / { why = ": " substr($0, 10) }
    why == "" && before ~ /: Skipped$/ { why = ": " $0 }
    { before = $0 }
    /^<end of output>$/ && name in skipped { print "skipped: " name why }
  ' "$log.skipped" build/release/Testing/Temporary/LastTest.log
fi
exit "$status"
