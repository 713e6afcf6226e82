#!/usr/bin/env bash
# The containers, checked on a real engine: the Dockerfile as it is, what is promised of the image, and every scenario of
# tools/compose for a short time. Leaves the images behind, and nothing else. Exits with 77 where no engine runs.
#
#   .ci/containers.sh             all of it; of a run of .ci/run that has built the images, it takes these
#   .ci/containers.sh --images    builds the images and looks at no more
set -euo pipefail
cd "$(dirname "$0")/.."
only_images=no
if [[ ${1:-} == --images ]]; then only_images=yes; fi
logs=out/ci/containers
if [[ $only_images == yes ]]; then logs=out/ci/images; fi
rm -rf "$logs"
mkdir -p "$logs"

if ! docker info >/dev/null 2>&1; then
  echo "no container engine answers 'docker info'"
  exit 77
fi
if ! docker compose version >/dev/null 2>&1 && ! command -v docker-compose >/dev/null; then
  echo "neither 'docker compose' nor 'docker-compose' is here"
  exit 77
fi
fail() { echo "containers.sh: $1" >&2; exit 1; }
server=
in_swarm=no
cleanup() {
  local status=$?
  if [[ -n $server ]]; then kill "$server" 2>/dev/null || true; fi
  if [[ $in_swarm == yes ]]; then leave_swarm || true; fi
  exit "$status"
}
trap cleanup EXIT
trap 'exit 143' TERM
trap 'exit 130' INT

# --- the images, by the same Dockerfile as everybody's; which way out of the machine apt takes there is this script's to say

built=out/ci/images.built # which run has built the images
exec 9>out/ci/images.lock
flock 9 # another step may be building them
.ci/base-image.sh
way_out=(--network host)
while read -r setting; do way_out+=(--build-arg "$setting"); done < <(.ci/debian-sources.sh environment)
# What step `test` has compiled needs no compiling again: same compiler, same files.
if [[ -d out/ci/ccache ]]; then
  : >"$logs/ccache.port" # is to be there before the server has begun
  python3 -u -m http.server --bind 127.0.0.1 --directory out/ci/ccache 0 >"$logs/ccache.port" 2>"$logs/ccache.log" 9>&- &
  server=$!
  for ((tries = 0; tries < 100; ++tries)); do
    port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$logs/ccache.port")
    if [[ -n $port ]]; then break; fi
    sleep 0.1
  done
  if [[ -n $port ]]; then
    way_out+=(--build-arg "CCACHE_REMOTE_STORAGE=http://127.0.0.1:$port|read-only=true")
  fi
fi
revision=$(git describe --always --dirty --tags 2>/dev/null || true)
build() { # TARGET TAG
  local started=$SECONDS
  docker build --quiet --force-rm "${way_out[@]}" --build-arg JOBS=2 --build-arg "PADR_REVISION=$revision" --target "$1" --tag "$2" . >"$logs/build-$1.log" 2>&1 ||
    { tail -n 40 "$logs/build-$1.log" >&2; fail "target $1 of the Dockerfile does not build"; }
  echo "$2: built in $((SECONDS - started)) s, $(($(docker image inspect --format '{{.Size}}' "$2") / 1000000)) MB"
}
if [[ -z ${PADR_CI_RUN:-} || $(cat "$built" 2>/dev/null) != "$PADR_CI_RUN" ]]; then
  build capture padr-capture:local
  build tc padr-tc:local
  build firewall padr-firewall:local
  build runtime padr:local
  echo "${PADR_CI_RUN:-}" >"$built"
fi
exec 9>&-
if [[ $only_images == yes ]]; then exit 0; fi

# --- what is promised of the image

(($(docker image inspect --format '{{.Size}}' padr:local) < 120000000)) || fail "the image is not under 120 MB"
[[ $(docker image inspect --format '{{.Config.User}}' padr:local) == padr ]] || fail "the image's user is not padr"
hardened=(docker run --rm --read-only --network none --cap-drop ALL --security-opt no-new-privileges)
programs=$("${hardened[@]}" padr:local sh -c 'cd /usr/local/bin && ls padr-*')
for program in padr-capture padr-lab padr-monitor padr-netem padr-peer padr-report; do
  [[ $programs == *$program* ]] || fail "no $program in the image"
done
for program in $programs; do
  "${hardened[@]}" padr:local "$program" --version || fail "$program does not start in a read-only container"
done
started=$(date +%s%N)
"${hardened[@]}" padr:local padr-peer --version >/dev/null
echo "a container from start to end: $((($(date +%s%N) - started) / 1000000)) ms"

# --- the scenarios, some at a time: starting containers is most of it

run_scenario() { # NAME SECONDS
  if tools/scenario.sh "$1" --duration "$2" --no-build --out "$logs/$1" >"$logs/$1.log" 2>&1; then
    echo "$1: $(grep '^Confirmed worlds' "$logs/$1.log")"
  elif [[ $1 == kernel-netem ]] && grep -q 'has no sch_netem' "$logs/$1.log"; then
    echo "$1: refused as it should be, this kernel has no sch_netem"
  else
    echo "$1 FAILED:"
    tail -n 15 "$logs/$1.log"
    return 1
  fi
}
failed=0
run_together() { # NAME:SECONDS...
  local entry pids=()
  for entry in "$@"; do
    run_scenario "${entry%:*}" "${entry#*:}" &
    pids+=($!)
  done
  for entry in "${pids[@]}"; do wait "$entry" || failed=1; done
}
run_together churn:40 partition:30 lan:15
run_together transatlantic:15 lossy-wifi:15 mobile-burst:15
run_together asymmetric:15 capture:15 kernel-netem:15
run_together crowd:15 monitor:15
run_together narrow:20 nat:20 no-direct:20

# The same file as a stack, where that is nobody's Swarm but ours.
leave_swarm() {
  local tries
  docker stack rm padr-ci >/dev/null 2>&1
  # The volume can go once no task has it any more.
  for ((tries = 0; tries < 30; ++tries)); do
    if docker volume rm padr-ci_traces >/dev/null 2>&1; then break; fi
    sleep 0.5
  done
  docker swarm leave --force >/dev/null && in_swarm=no
  docker network rm docker_gwbridge >/dev/null 2>&1
}
report_state() { docker service ps padr-ci_report --format '{{.CurrentState}}' 2>/dev/null; }
if [[ $(docker info --format '{{.Swarm.LocalNodeState}}') == inactive ]]; then
  if docker swarm init --advertise-addr 127.0.0.1 >"$logs/swarm.log" 2>&1; then
    in_swarm=yes
    PADR_DURATION=12 docker stack deploy -c docker-compose.yml padr-ci >>"$logs/swarm.log" 2>&1
    for ((tries = 0; tries < 90; ++tries)); do
      if [[ $(report_state) =~ Complete|Failed|Rejected ]]; then break; fi
      sleep 1
    done
    docker service logs --raw padr-ci_report >>"$logs/swarm.log" 2>&1 || true
    if [[ $(report_state) == Complete* ]]; then
      echo "swarm: $(grep '^Confirmed worlds' "$logs/swarm.log")"
    else
      echo "swarm FAILED:"
      docker service ps padr-ci_peer1 padr-ci_report --no-trunc
      tail -n 15 "$logs/swarm.log"
      failed=1
    fi
    leave_swarm || true
  else
    echo "swarm: this engine will not be one: $(tail -n 1 "$logs/swarm.log")"
  fi
else
  echo "swarm: this engine is part of one already: not tried"
fi
for entry in tools/compose/*.yml; do
  name=$(basename "$entry" .yml)
  [[ -e $logs/$name.log ]] || fail "scenario $name has not been run"
done
if ((failed != 0)); then exit 1; fi

# And a session that cannot come about is no success.
if PADR_ARGS=--no-such-flag tools/scenario.sh lan --no-build --out "$logs/wrong" >"$logs/wrong.log" 2>&1; then
  fail "tools/scenario.sh says that all is well where no peer could start"
fi
for name in lan churn crowd partition; do
  left=$(docker ps --all --quiet --filter "label=com.docker.compose.project=padr-$name")
  [[ -z $left ]] || fail "containers of padr-$name are left"
done
