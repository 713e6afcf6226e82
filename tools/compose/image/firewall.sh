#!/bin/sh
# A side-car in the network of one peer: what its kernel lets through there. PADR_FIREWALL is one of
#
#   cut NAME...   nothing from these peers
#   keeps-ports   as behind a NAT: only from where this peer has sent something to
#   symmetric     as behind a NAT that shows this peer to each other one at another port; besides, as keeps-ports
set -u

ready=${PADR_DATA:-/data}/firewall${PADR_NUMBER:?}.ready
port=${PADR_PORT:-7001}
patience=${PADR_JOIN_TIMEOUT:-60}
rm -f "$ready"
fail() {
  echo "compose-firewall: $1" >&2
  exit 1
}

# The engine may start us before those whose addresses are asked for.
address_of() { # NAME
  deadline=$(($(date +%s) + patience)) # one look can take 20 s
  until address=$(getent ahostsv4 "$1") && [ -n "$address" ]; do
    if [ "$(date +%s)" -ge "$deadline" ]; then fail "there is no '$1' on this network after $patience s"; fi
    sleep 1
  done
  echo "$address" | { read -r first _; echo "$first"; }
}

rules() {
  # shellcheck disable=SC2086 # a list of words
  set -- ${PADR_FIREWALL:-}
  kind=${1:-}
  echo "table ip padr {"
  case $kind in
    cut)
      shift
      echo "  chain in { type filter hook input priority 0;"
      for name in "$@"; do
        address=$(address_of "$name") || exit 1
        echo "    ip saddr $address drop"
      done
      echo "  }" ;;
    keeps-ports | symmetric)
      echo "  chain in { type filter hook input priority 0; iifname != \"lo\" udp dport $port ct state new drop; }"
      if [ "$kind" = symmetric ]; then
        echo "  chain out { type nat hook postrouting priority 100; udp sport $port masquerade fully-random; }"
      fi ;;
    *) fail "PADR_FIREWALL '${PADR_FIREWALL:-}': give cut NAME..., keeps-ports or symmetric" ;;
  esac
  echo "}"
}

text=$(rules) || exit 1
if ! said=$(echo "$text" | nft -f - 2>&1); then
  fail "nft: $(echo "$said" | head -n 2)"
fi
nft list ruleset >"$ready"
stop() {
  rm -f "$ready"
  exit 0
}
trap stop TERM INT
while :; do # the peer waits for a fresh one
  touch "$ready"
  sleep 1
done
