#!/bin/sh
# One peer of docker-compose.yml: turns its environment into padr-peer's command line.
#
# Peer 1 founds the session and the others join it, unless a session is being played already: who comes back to one,
# founder or not, joins whoever is there. Whether one is, the peers' health files tell, in the folder that all share.
set -eu

data=${PADR_DATA:-/data}
number=${PADR_NUMBER:?"the number of this peer, from 1"}
port=${PADR_PORT:-7001}
patience=${PADR_JOIN_TIMEOUT:-60}

trap 'exit 143' TERM INT # the first process of a container would not mind them otherwise
say() { echo "compose-peer: $*" >&2; }

# The lock goes with the last process that has it open.
if [ -w "$data" ]; then
  exec 9>"$data/.peer$number.lock"
  if ! flock --nonblock 9; then
    say "another container is peer $number already; for more peers than four see tools/compose/crowd.yml, not --scale"
    exit 1
  fi
fi

# As padr-peer's own, so that the report knows of us, and nobody takes that of a life before for this one.
alive=$data/peer$number.health
trap 'rm -f "$alive"' EXIT
tell_alive() { { echo '{ "healthy": false, "playing": false }' >"$alive"; } 2>/dev/null || true; }
tell_alive

# Names one that is in a session, playing or waiting; nothing when there is none. Those that were killed leave their files,
# so one counts that is written after this began. Until all that are there have become old, there may be such a one.
began=$(date +%s.%N)
written_since() { # WHEN, as find has it
  find "$data" -maxdepth 1 -name 'peer*.health' ! -name "peer$number.health" -newermt "$1" \
    -exec grep -l '"present": [1-9]' {} + 2>/dev/null | sed -n 's|.*/\(peer[0-9]*\)[.]health$|\1|p' | head -n 1
}
somebody_there() {
  while [ -n "$(written_since '-5 seconds')" ]; do
    living=$(written_since "@$began")
    if [ -n "$living" ]; then
      echo "$living"
      return
    fi
    sleep 0.2
  done
}

# In a Swarm the name of a service stands for a balanced address; that of the peer itself is under tasks. there.
address_of() { # SERVICE
  case ${PADR_TASK:-} in
    "" | "{{"*) echo "$1" ;;
    *) echo "tasks.$1" ;;
  esac
}

# The engine may start us before the one that we join.
wait_for_name() { # NAME
  deadline=$(($(date +%s) + patience))
  until timeout 3 getent hosts "$1" >/dev/null; do # which may take 20 s to say no
    tell_alive
    if [ "$(date +%s)" -ge "$deadline" ]; then
      say "there is no '$1' on this network after $patience s"
      exit 1
    fi
    sleep 1
  done
}

file=$data/peer$number
remove_recordings() { # FIND'S TESTS
  find "$data" -maxdepth 1 "$@" \( -name "peer$number.*trace" -o -name "peer$number.*json" -o -name "peer$number.*pcapng" \) \
    -exec rm -f {} + 2>/dev/null || true
}
member=$(somebody_there)
if [ -n "$member" ]; then
  # What was recorded since the session was founded belongs to it.
  remove_recordings ! -newer "$data/.founded"
  times=1
  while [ -e "$file.trace" ]; do
    file=$data/peer$number.back$times
    times=$((times + 1))
  done
else
  remove_recordings
  if [ "$number" -eq 1 ]; then touch "$data/.founded" || true; else member=peer1; fi
fi

# A capture that shall have everything has to be there first. It says so again and again, in a file: one that an earlier
# run has left behind is old.
waited=0
while [ -n "${PADR_AFTER_FILE:-}" ] && [ -z "$(find "$PADR_AFTER_FILE" -newermt '-5 seconds' 2>/dev/null)" ]; do
  tell_alive
  if [ "$waited" -ge "$((patience * 10))" ]; then
    say "no fresh $PADR_AFTER_FILE after $patience s"
    exit 1
  fi
  waited=$((waited + 1))
  sleep 0.1
done

if [ -n "$member" ]; then
  member=$(address_of "$member")
  wait_for_name "$member"
  set -- --join "$member:$port"
else
  set -- --wait-peers "${PADR_PEERS:-4}"
fi
# An empty one of its own is none.
netem=$(printenv "PADR_NETEM_$number") || netem=${PADR_NETEM:-}
if [ -n "$netem" ]; then set -- "$@" --netem "$netem"; fi

if [ -n "${PADR_MONITOR:-}" ]; then set -- "$@" --monitor "$PADR_MONITOR" --control; fi
if [ -n "${PADR_OWN_CAPTURE:-}" ]; then set -- "$@" --pcap "$file.pcapng"; fi

# The network is the session's own; see there. A key, if there is one, padr-peer takes from PADR_KEY itself.
if [ -z "${PADR_KEY:-}" ]; then set -- "$@" --insecure; fi

if [ -n "${PADR_MEETING_POINT:-}" ]; then
  set -- "$@" --meeting-point
else
  set -- "$@" --input "${PADR_INPUT:-wander}"
fi

# The seed, and two digits for the peer: another one for each. Of a long one the end is enough.
seed=${PADR_SEED:-1}
netem_seed=$(printf '%s%02d' "$seed" "$number" | tail -c 17)
netem_seed=${netem_seed#"${netem_seed%%[!0]*}"}

# PADR_ARGS is a list of words.
# shellcheck disable=SC2086
exec padr-peer "$@" --listen "0.0.0.0:$port" --join-timeout "$patience" \
  --scenario "${PADR_SCENARIO:-arena}" --seed "$seed" --technique "${PADR_TECHNIQUE:-full}" \
  --duration "${PADR_DURATION:-60}" \
  --netem-seed "$netem_seed" \
  --trace "$file.trace" --json "$file.json" --health "$alive" ${PADR_ARGS:-}
