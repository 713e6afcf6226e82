#!/usr/bin/env bash
# One of the scenarios of tools/compose, from the start of its containers to the report and away with them.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/scenario.sh NAME [options]
       tools/scenario.sh --list

Builds the images, starts the peers of docker-compose.yml with tools/compose/NAME.yml, sees them become healthy, does what
the scenario is about, waits for the report, copies all that was recorded, and removes containers, network and volume.

  --duration S   seconds to play, 10 to 3600; in churn and partition from 30   (default 30)
  --seed N       of the world, the inputs and the network                      (default 1)
  --out DIR      where traces, captures and the report go: a new folder, an empty one, or that of an earlier run, which is
                 emptied                                                       (default out/scenario/NAME)
  --no-build     take the images as they are
  --keep         leave containers, network and volume, for a look inside
  --list         names of the scenarios, and what each is
  --help         this text

Needs a container engine, and Compose v2 or docker-compose 1.29. What docker-compose.yml takes from the environment
(PADR_NETEM, PADR_TECHNIQUE, PADR_IMAGE, ...) it takes here too, before the scenario's own.

Exit status: 0 when every peer ended well, those that were killed or cut off came back, and all confirmed worlds were
identical; 1 otherwise; 2 for wrong arguments.
TEXT
}

fail_usage() { echo "scenario.sh: $1 (see --help)" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
list() { (cd "$here/compose" && for f in *.yml; do printf '%-14s %s\n' "${f%.yml}" "$(sed -n '1s/^# //p' "$f")"; done); }

name=
duration=30
seed=1
out=
mark=.made-by-tools-scenario # only a folder with this file is emptied
build=yes
keep=no
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --list) list; exit 0 ;;
    --no-build) build=no; shift ;;
    --keep) keep=yes; shift ;;
    --duration=* | --seed=* | --out=*)
      set -- "${1%%=*}" "${1#*=}" "${@:2}"
      continue ;;
    --duration | --seed | --out)
      if (($# < 2)); then fail_usage "$1 needs a value"; fi
      case $1 in
        --duration) duration=$2 ;;
        --seed) seed=$2 ;;
        --out)
          if [[ -z $2 ]]; then fail_usage "--out must not be empty"; fi
          out=$(realpath -m -- "$2") ;;
      esac
      shift 2 ;;
    -*) fail_usage "unknown argument '$1'" ;;
    *)
      if [[ -n $name ]]; then fail_usage "one scenario at a time: '$name' or '$1'"; fi
      name=$1
      shift ;;
  esac
done

if [[ -z $name ]]; then fail_usage "which scenario? one of: $(list | cut -d' ' -f1 | paste -sd' ')"; fi
if [[ ! $name =~ ^[a-z-]+$ || ! -e $here/compose/$name.yml ]]; then
  fail_usage "no scenario '$name'; one of: $(list | cut -d' ' -f1 | paste -sd' ')"
fi
# At most nine digits: the shell's arithmetic shall never overflow, and 10# keeps a leading zero from meaning octal.
check_number() { # FLAG VALUE LOWEST HIGHEST
  if ! [[ $2 =~ ^[0-9]{1,9}$ ]] || ((10#$2 < $3 || 10#$2 > $4)); then
    fail_usage "$1 '$2': must be a whole number from $3 to $4"
  fi
}
case $name in
  churn | partition) check_number --duration "$duration" 30 3600 ;;
  *) check_number --duration "$duration" 10 3600 ;;
esac
check_number --seed "$seed" 0 9999999
duration=$((10#$duration)) seed=$((10#$seed))
cd "$here/.."
if [[ -z $out ]]; then out=out/scenario/$name; fi
if [[ -e $out && ! -d $out ]]; then fail_usage "--out '$out' is no directory"; fi
if [[ -d $out && ! -e $out/$mark && -n $(ls -A -- "$out") ]]; then
  fail_usage "--out '$out' has files that no scenario put there; name another folder"
fi
make_out() {
  mkdir -p "$out"
  : >"$out/$mark"
}

fail() { echo "scenario.sh: $1" >&2; exit 1; }
if ! docker info >/dev/null 2>&1; then fail "no container engine answers 'docker info'"; fi
if docker compose version >/dev/null 2>&1; then
  compose=(docker compose)
elif command -v docker-compose >/dev/null; then
  compose=(docker-compose)
else
  fail "neither 'docker compose' nor 'docker-compose' is here"
fi
project=padr-$name
compose() { "${compose[@]}" --project-name "$project" -f docker-compose.yml -f "tools/compose/$name.yml" "$@"; }

# --- containers, whichever way Compose names them

containers() { # [SERVICE]: ids, also of those that have ended
  docker ps --all --quiet --filter "label=com.docker.compose.project=$project" \
    ${1:+--filter "label=com.docker.compose.service=$1"}
}
state() { docker inspect --format "{{.State.$2}}" "$(containers "$1")"; } # SERVICE FIELD
# Two at a time would have the same containers.
if [[ -n $(containers report) && $(state report Running) == true ]]; then
  fail "'$name' is being played already; wait for it, or end it by: ${compose[*]} --project-name $project down --volumes --remove-orphans"
fi
peers=()
cars=() # beside them
for service in $(compose config --services | sort -V); do
  case $service in
    peer*) peers+=("$service") ;;
    capture* | tc* | firewall*) cars+=("$service") ;;
  esac
done

log=$(mktemp)
quietly() { "$@" >"$log" 2>&1 || { cat "$log" >&2; fail "failed: $*"; }; }

stopped() {
  local status=$?
  trap - EXIT
  if ((status != 0 && status != 2)) && [[ -n $(containers) ]]; then
    make_out
    compose logs --no-color >"$out/containers.log" 2>&1 || true
    echo "scenario.sh: what the containers said is in $out/containers.log" >&2
  fi
  if [[ $keep == no ]]; then compose down --volumes --timeout 1 >/dev/null 2>&1 || true; fi
  rm -f "$log"
  exit "$status"
}
trap stopped EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# Peers are to become healthy, and stay alive while they wait for it.
wait_healthy() { # SECONDS SERVICE...
  local deadline=$((SECONDS + $1)) service car
  for service in "${@:2}"; do
    until [[ $(state "$service" Health.Status) == healthy ]]; do
      for car in "${cars[@]}"; do
        if [[ $(state "$car" Status) == exited ]]; then
          docker logs --tail 3 "$(containers "$car")" >&2
          fail "$car ended: the peers wait for it in vain"
        fi
      done
      if [[ $(state "$service" Running) != true ]]; then
        docker logs --tail 3 "$(containers "$service")" >&2
        fail "$service ended instead of becoming healthy"
      fi
      if ((SECONDS >= deadline)); then fail "$service has not become healthy"; fi
      sleep 0.5
    done
  done
}

# --- what happens in the stories

said() { echo "  $((SECONDS - began)) s: $*"; }
sit_out() { while ((SECONDS - began < duration)); do sleep 0.5; done; }
lives=0 # that have to begin besides the first of each peer

# One peer after another, the founder second, is killed and started again, as long as it can be back in time.
play_churn() {
  local victims=(peer2 peer1 peer3 peer4) next=0 victim
  while ((duration - (SECONDS - began) >= 22)); do
    victim=${victims[next++ % 4]}
    docker kill "$(containers "$victim")" >/dev/null
    said "$victim killed"
    sleep 1
    docker start "$(containers "$victim")" >/dev/null
    wait_healthy 20 "$victim"
    said "$victim started again and healthy"
    lives=$((lives + 1))
    sleep 2
  done
  sit_out
}

# Two peers are cut off, each by itself, for longer than it takes to be declared gone.
play_partition() {
  local network service addresses=()
  network=$(docker network ls --quiet --filter "label=com.docker.compose.project=$project")
  sleep 4
  for service in peer3 peer4; do
    addresses+=("$(docker inspect --format '{{range .NetworkSettings.Networks}}{{.IPAddress}}{{end}}' "$(containers "$service")")")
    docker network disconnect "$network" "$(containers "$service")"
  done
  said "peer3 and peer4 cut off"
  sleep 8
  for service in peer3 peer4; do
    docker network connect --ip "${addresses[0]}" --alias "$service" "$network" "$(containers "$service")"
    addresses=("${addresses[@]:1}")
    lives=$((lives + 1))
  done
  said "peer3 and peer4 connected again"
  sit_out
}

# --- from start to report

export PADR_SEED=$seed PADR_DURATION=$duration
case $name in churn | partition) export PADR_DURATION=0 ;; esac # until stopped

quietly compose down --volumes --remove-orphans --timeout 1
if [[ $build == yes ]]; then
  echo "== building the images"
  compose build || fail "the images cannot be built"
fi
# Without a key, nobody could carry for others.
if [[ $name =~ ^(nat|no-direct)$ && -z ${PADR_KEY:-} ]]; then
  PADR_KEY=$(docker run --rm --read-only --network none --cap-drop ALL "${PADR_IMAGE:-padr:local}" padr-peer keygen) || fail "there is no key"
  export PADR_KEY
fi
rm -rf "$out"
make_out
echo "== $name: ${#peers[@]} peers for $duration s"
quietly compose up --detach --no-build
wait_healthy 60 "${peers[@]}"
began=$SECONDS
echo "  all healthy"
case $name in
  churn | partition)
    "play_$name"
    quietly compose stop ;;
esac

deadline=$((SECONDS + duration + 60))
while [[ $(state report Running) == true ]]; do
  if ((SECONDS >= deadline)); then fail "no report after $((duration + 60)) s"; fi
  sleep 0.5
done
if ((${#cars[@]} > 0)); then quietly compose stop "${cars[@]}"; fi

docker cp "$(containers report):/data/." "$out" >/dev/null
if [[ -e $out/report/report.txt ]]; then cat "$out/report/report.txt"; fi

# --- judge

for service in "${peers[@]}"; do
  status=$(state "$service" ExitCode)
  if ((status != 0)); then
    docker logs --tail 3 "$(containers "$service")" >&2
    fail "$service exited with status $status"
  fi
done
if (($(state report ExitCode) != 0)); then
  docker logs "$(containers report)" 2>&1 >/dev/null | tail -n 5 >&2
  fail "the report says no: $out/report"
fi
began_lives=$(sed -n 's/^  "lives": \([0-9]*\),*$/\1/p' "$out/report/report.json")
if ((began_lives < ${#peers[@]} + lives)); then
  fail "only $began_lives lives in the report, not ${#peers[@]} and $lives more"
fi

# Those that do not reach each other said so, and by whom they do.
must_be_carried() { # SERVICE...
  local service line
  for service in "$@"; do
    docker logs "$(containers "$service")" >"$log" 2>&1
    line=$(grep -m 1 -o 'peer [0-9]* is reached through peer.*' "$log") || fail "$service was carried by nobody"
    echo "$service: $line"
  done
}
case $name in
  nat) must_be_carried peer3 peer4 ;;
  no-direct) must_be_carried peer2 peer3 ;;
esac

# --- what the packets tell, by themselves

packets() { # COMMAND
  docker run --rm --read-only --network none --cap-drop ALL --security-opt no-new-privileges \
    --volume "${project}_traces:/data:ro" "${PADR_IMAGE:-padr:local}" sh -c "$1"
}
if [[ $name == capture ]]; then
  for kind in pcap pcapng; do
    packets "padr-capture compare peer*.$kind peer*.trace" >"$out/report/compare-$kind.txt" ||
      fail "captures (*.$kind) and traces do not agree: $out/report/compare-$kind.txt"
    echo
    echo "*.$kind: $(tail -n 1 "$out/report/compare-$kind.txt")"
    packets "padr-capture rebuild peer*.$kind" || fail "the world cannot be rebuilt from *.$kind"
  done
fi
echo
echo "traces and report: $out"
echo "All confirmed worlds were identical."
