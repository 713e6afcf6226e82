#!/bin/sh
# A side-car in the network of one peer: writes what goes in and out there to its pcap file until the peer has ended.
set -u

data=${PADR_DATA:-/data}
peer=$data/peer${PADR_NUMBER:?}
ready=$peer.capturing
rm -f "$ready"
started=$(date +%s)

# Once it has its socket, tcpdump goes on as the user whom the folder belongs to. A file that it opened itself it would
# want to give away before, which takes one more capability.
# The buffer is divided into places of the snapshot length, 256 KiB by default: too few places.
tcpdump -p --immediate-mode -s 2048 -B 4096 -Z padr -i eth0 -U -w - udp port "${PADR_PORT:-7001}" >"$peer.pcap" &
dump=$!
stop() {
  rm -f "$ready"
  kill -TERM "$dump" 2>/dev/null
  wait "$dump"
  exit "$?"
}
trap stop TERM INT

# The peer waits for a fresh sign that tcpdump has its socket. The summary is what a peer completes last.
while kill -0 "$dump" 2>/dev/null; do
  if [ -s "$peer.pcap" ]; then touch "$ready"; fi
  if [ ! -e "$peer.health" ] && [ -n "$(find "$peer.json" -size +0 -newermt "@$started" 2>/dev/null)" ]; then stop; fi
  sleep 0.5
done
rm -f "$ready"
wait "$dump"
