#!/usr/bin/env bash
# Real peer processes over UDP through a bad network, one killed every few seconds and another started: what the
# survivors believe has to be the same.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/chaos.sh [options]

Installs missing packages, builds padr-peer, plays, prints a row for each survivor and the verdict.

  --seconds S      how long to play, 8 to 3600                    (default 30)
  --peers N        peers at a time, 3 to 14                       (default 10)
  --netem SPEC     impairment of every directed link, in the grammar of tc-netem; "" for none
                   (default "delay 60ms 20ms loss 2%")
  --kill-every S   seconds from one kill -9 to the next, 1 to 3600; another peer is started each time (default 5)
  --seed N         of who is killed, the inputs and the network   (default 1)
  --help           this text

Nobody is killed in the last six seconds, so that the last one can be missed and declared gone. Late ticks and stalls are
of the machine, too: ten peers want a processor that is not busy with anything else.

PADR_JOBS=N in the environment bounds the parallel build jobs.

Exit status: 0 when all confirmed worlds of survivors were identical and every newcomer came in; 1 otherwise, with the logs
of all processes; 2 for wrong arguments.
TEXT
}

fail_usage() { echo "chaos.sh: $1 (see --help)" >&2; exit 2; }

seconds=30
peers=10
netem='delay 60ms 20ms loss 2%'
kill_every=5
seed=1
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --seconds=* | --peers=* | --netem=* | --kill-every=* | --seed=*)
      set -- "${1%%=*}" "${1#*=}" "${@:2}"
      continue ;;
    --seconds | --peers | --netem | --kill-every | --seed)
      if (($# < 2)); then fail_usage "$1 needs a value"; fi
      case $1 in
        --seconds) seconds=$2 ;;
        --peers) peers=$2 ;;
        --netem) netem=$2 ;;
        --kill-every) kill_every=$2 ;;
        --seed) seed=$2 ;;
      esac
      shift 2 ;;
    *) fail_usage "unknown argument '$1'" ;;
  esac
done

# At most nine digits: the shell's arithmetic shall never overflow, and 10# keeps a leading zero from meaning octal.
check_number() { # FLAG VALUE LOWEST HIGHEST
  if ! [[ $2 =~ ^[0-9]{1,9}$ ]] || ((10#$2 < $3 || 10#$2 > $4)); then
    fail_usage "$1 '$2': must be a whole number from $3 to $4"
  fi
}
check_number --seconds "$seconds" 8 3600
check_number --peers "$peers" 3 14
check_number --kill-every "$kill_every" 1 3600
check_number --seed "$seed" 0 999999999

cd "$(dirname "$0")/.."
jobs=${PADR_JOBS:-$(nproc)}
if ! [[ $jobs =~ ^[1-9][0-9]*$ ]]; then fail_usage "PADR_JOBS is '$jobs', must be a number from 1"; fi

tools/deps.sh build run
if ! command -v python3 >/dev/null; then tools/deps.sh test; fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
without_tests=()
if [[ ! -e build/release/CMakeCache.txt ]]; then without_tests=(-DPADR_TESTS=OFF); fi
echo "== configuring build/release"
if ! cmake --preset release "${without_tests[@]}" >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
echo "== building"
cmake --build build/release --parallel "$jobs" --target padr-peer
# A specification that the peers would refuse is said so once, not by each of them.
if ! build/release/bin/padr-peer --wait-peers 1 --duration 0.1 --netem "$netem" 2>"$log"; then
  cat "$log" >&2
  exit 2
fi
echo "== $peers peers, netem \"$netem\", one killed every $((10#$kill_every)) s, for $((10#$seconds)) s"
python3 -B tests/e2e/crowd.py build/release/bin/padr-peer --seconds "$((10#$seconds))" --peers "$((10#$peers))" \
  --netem "$netem" --kill-every "$((10#$kill_every))" --seed "$((10#$seed))"
