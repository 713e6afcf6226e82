#!/bin/sh
# A side-car in the network of one peer: lets the kernel impair all that goes out there, as long as this runs.
set -u

ready=${PADR_DATA:-/data}/tc${PADR_NUMBER:?}.ready
rm -f "$ready"
# shellcheck disable=SC2086 # a list of words
if ! said=$(tc qdisc replace dev eth0 root netem ${PADR_TC:-delay 50ms 10ms loss 2%} 2>&1); then
  echo "compose-tc: PADR_TC '${PADR_TC:-}': $(echo "$said" | head -n 2)" >&2
  case $said in
    *"qdisc kind is unknown"*)
      echo "compose-tc: this kernel has no sch_netem: 'modprobe sch_netem' on the host, or use the peers' own shim" >&2 ;;
  esac
  exit 1
fi
tc qdisc show dev eth0 >"$ready"
stop() {
  rm -f "$ready"
  exit 0
}
trap stop TERM INT
while :; do # the peer waits for a fresh one
  touch "$ready"
  sleep 1
done
