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

tools/deps.sh build test
log=$(mktemp)
trap 'rm -f "$log"' EXIT
echo "== configuring build/release"
if ! cmake --preset release -DPADR_TESTS=ON >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
echo "== building"
cmake --build build/release --parallel "$jobs"
echo "== testing"
# Many tests are real processes that wait more than they compute.
ctest --test-dir build/release --output-on-failure --no-tests=error --parallel $((jobs + 1)) "$@"
