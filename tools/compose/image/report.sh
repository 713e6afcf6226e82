#!/bin/sh
# Waits until the peers of docker-compose.yml have ended, by themselves or because all is being stopped, and reports:
# the table to standard output and report/report.txt, the rest beside it. Exit code 0 only if the traces of all peers
# are there and all their confirmed worlds were identical.
set -u

data=${PADR_DATA:-/data}
peers=${PADR_PEERS:-4}
started=$(date +%s)
stopping=no
trap 'stopping=yes' TERM INT

say() { echo "compose-report: $*" >&2; }
fail() { say "$@"; exit 1; }

anybody_alive() { find "$data" -maxdepth 1 -name 'peer*.health' -newermt '-5 seconds' 2>/dev/null | grep -q .; }

# A peer removes its health file and completes its summary last of all.
has_ended() { # NUMBER
  [ ! -e "$data/peer$1.health" ] && find "$data" -maxdepth 1 \( -name "peer$1.json" -o -name "peer$1.*.json" \) \
    -size +0 -newermt "@$started" | grep -q .
}

all_ended() {
  n=1
  while [ "$n" -le "$peers" ]; do
    has_ended "$n" || return 1
    n=$((n + 1))
  done
}

# Ends when there is nothing to wait for: all have ended, or who has not was killed and does not come back.
wait_for_end() {
  seen=no
  quiet=0
  while ! all_ended; do
    if anybody_alive; then seen=yes quiet=0; else quiet=$((quiet + 1)); fi
    if [ "$seen" = no ] && [ "$stopping" = yes ]; then fail "stopped before anybody played"; fi
    if [ "$seen" = no ] && [ "$quiet" -gt $((${PADR_JOIN_TIMEOUT:-60} + 30)) ]; then fail "nobody plays"; fi
    if [ "$seen" = yes ] && [ "$quiet" -gt 15 ]; then return; fi
    if [ "$stopping" = yes ] && [ "$quiet" -gt 1 ]; then return; fi
    sleep 1
  done
}

# Older traces are of a session before. In a Swarm the founder may be on another node, and its sign there.
of_this_session() {
  [ -s "$1" ] && { [ ! -e "$data/.founded" ] || [ -n "$(find "$1" -newer "$data/.founded")" ]; }
}

wait_for_end
n=1
set --
while [ "$n" -le "$peers" ]; do
  before=$#
  for trace in "$data/peer$n.trace" "$data/peer$n".*.trace; do
    if of_this_session "$trace"; then set -- "$@" "$trace"; fi
  done
  if [ $# -eq "$before" ]; then fail "peer $n has left no trace"; fi
  n=$((n + 1))
done

report=$data/report
rm -rf "$report"
mkdir "$report" || exit 1
padr-report "$@" --csv "$report" --json "$report/report.json" >"$report/report.txt" 2>"$report/messages.txt"
verdict=$?
cat "$report/report.txt"
cat "$report/messages.txt" >&2
if [ "$verdict" -ne 0 ]; then exit "$verdict"; fi
ticks=$(sed -n 's/^  "confirmed_ticks": \([0-9]*\),*$/\1/p' "$report/report.json")
if [ "${ticks:-0}" -eq 0 ]; then fail "no tick was confirmed by two peers: nothing has been compared"; fi
say "$peers peers, confirmed worlds identical at all $ticks ticks compared"
