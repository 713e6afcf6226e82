#!/usr/bin/env bash
# Several real peer processes on this machine, playing in one world over UDP through a bad network, a page to look at them
# and to play along, and a report of how consistent they were and what it cost.
set -euo pipefail

# In the repository this is tools/demo.sh, which builds the programs; installed it is padr-demo, beside the programs.
here=$(cd "$(dirname "$0")" && pwd)
if [[ -e $here/deps.sh ]]; then
  installed=no me=demo.sh paths=$here/../common/scenarios/paths
else
  installed=yes me=padr-demo paths=$here/../share/padr/paths
fi

usage() {
  if [[ $installed == no ]]; then
    echo "usage: tools/demo.sh [options]"
    echo
    echo "Installs missing packages, builds the programs, runs N peers against one another with a page that shows them, prints the"
    echo "report."
  else
    echo "Several peers play in one world through a bad network, with a page to look at them and to play along, and a report."
    echo "Usage: padr-demo [OPTIONS]"
    echo
    echo "Options:"
  fi
  cat <<'TEXT'

  --peers N         number of peers, 2 to 64                 (default 4)
  --duration S      seconds to play, 1 to 3600; default: 30, or, in a terminal and with a page, 1800 or until Ctrl-C,
                    after which there is a report as well
  --page PORT|off   port of 127.0.0.1 at which a browser finds the page, 0 for any; off: there is none
                    (default 8080, or any if that is taken)
  --scenario NAME|FILE
                    arena, clutter, ball, dominoes, van, proxy, pitch, or a scenario file   (default arena)
  --netem SPEC      impairment of every directed link, in the grammar of tc-netem; "" for none
                    (default "delay 100ms 50ms loss 10%")
  --technique NAME  avatar-only, fixed, adaptive, full or everything   (default full)
  --scene NAME      stop-short, predictor or proxy: a story of the paper, or made from one, in place of made-up play; sets
                    the other defaults, flags beside it still count:
                    stop-short: the avatar of peer 0 stops just short of a ball, nobody has authority, and its model
                      runs on into the ball at the others'; also with --scenario dominoes or van, or --technique full
                    predictor: the same before dominoes, with a predictor that sees what the model is about to do
                    proxy: the avatar of peer 0 pushes one thing into another and that into a third
  --seed N          seed of the scenario, the inputs and the network   (default 1)
  --out DIR         where traces, logs, plots and tables go: a new folder, an empty one, or that of an earlier demo,
                    whose recording gives way  (default out/demo)
TEXT
  if [[ $installed == yes ]]; then echo "  --version         version of the programs"; fi
  cat <<'TEXT'
  --help            this text

TEXT
  if [[ $installed == no ]]; then
    echo "PADR_JOBS=N in the environment bounds the parallel build jobs."
    echo
  fi
  echo "Exit status: 0 when every peer ended well and all confirmed worlds were identical; 1 otherwise; 2 for wrong arguments."
}

fail_usage() { echo "$me: $1 (see --help)" >&2; exit 2; }

peers=4
duration=
page=
scenario=arena
netem='delay 100ms 50ms loss 10%'
technique=full
seed=1
out=out/demo
scene=
scene_flags=() # for every peer, as long as the technique is the scene's
set_scene() { # NAME
  scene=$1 peers=2 netem=
  case $scene in
    stop-short) scenario=ball technique=avatar-only scene_flags=(--threshold 0.8) ;;
    predictor) scenario=dominoes technique=avatar-only scene_flags=(--threshold 0.8:0.3 --predictor pcc) ;;
    proxy) scenario=proxy technique=adaptive ;;
    *) fail_usage "--scene '$scene': must be one of: stop-short predictor proxy" ;;
  esac
}
# First, so that flags before it count as well as those behind it.
for ((i = 1; i <= $#; ++i)); do
  next=$((i + 1))
  case ${!i} in
    --scene=*) set_scene "${!i#*=}" ;;
    --scene) set_scene "${!next-}" ;;
  esac
done
scenes_technique=$technique
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --version)
      if [[ $installed == yes ]]; then
        version=$("$here/padr-peer" --version)
        echo "padr-demo ${version#* }"
        exit 0
      fi
      fail_usage "unknown argument '$1'" ;;
    --peers=* | --duration=* | --page=* | --scenario=* | --netem=* | --technique=* | --seed=* | --out=* | --scene=*)
      set -- "${1%%=*}" "${1#*=}" "${@:2}"
      continue ;;
    --peers | --duration | --page | --scenario | --netem | --technique | --seed | --out | --scene)
      if (($# < 2)); then fail_usage "$1 needs a value"; fi
      case $1 in
        --peers) peers=$2 ;;
        --duration) duration=$2 ;;
        --page) page=$2 ;;
        --scenario) scenario=$2 ;;
        --netem) netem=$2 ;;
        --technique) technique=$2 ;;
        --seed) seed=$2 ;;
        --out) out=$2 ;;
        --scene) ;; # set already
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
# Whether a socket of this machine has the port, in that state if one is given. A machine without IPv6 lacks one of the
# files.
in_use() { # tcp|udp PORT [STATE]
  local hex
  printf -v hex ':%04X %s' "$((10#$2))" "${3-}"
  { cat "/proc/net/$1" "/proc/net/${1}6" 2>/dev/null || true; } | awk '{ print $2 " " $4 }' | grep -F -- "$hex" >/dev/null
}
readonly listens=0A
if [[ -z $page ]]; then
  page=8080
  # Whether somebody listens there, or did a moment ago.
  if in_use tcp 8080; then page=0; fi
elif [[ $page != off ]]; then
  check_number --page "$page" 0 65535
  if in_use tcp "$page" "$listens"; then
    fail_usage "--page '$page': another program listens there; give another port, 0 for any free one, or off"
  fi
fi
if [[ -z $duration ]]; then
  duration=30
  if [[ -n $scene && $page == off ]]; then duration=12; fi
  if [[ -t 1 && $page != off ]]; then duration=1800; fi
fi
check_number --peers "$peers" 2 64
check_number --duration "$duration" 1 3600
check_number --seed "$seed" 0 999999999
peers=$((10#$peers)) duration=$((10#$duration)) seed=$((10#$seed))
# A wrong name shall not wait for the build to be refused. Where the list cannot be read, the peers refuse it.
techniques=$(sed -n '/technique_names() {/,/}/s/.*return {\(.*\)};/\1/p' "$here/../common/model/technique.cpp" 2>/dev/null | tr -d '",' || true)
if [[ -n $techniques && ($technique == *" "* || " $techniques " != *" $technique "*) ]]; then
  fail_usage "--technique '$technique': must be one of: $techniques"
fi
if [[ $technique != "$scenes_technique" ]]; then scene_flags=(); fi
path=$(realpath -m -- "$paths/$scenario.csv")
if [[ -n $scene && ! -e $path ]]; then
  fail_usage "--scene $scene: --scenario must be one of: ball dominoes van proxy"
fi
if [[ -z $scenario ]]; then fail_usage "--scenario must not be empty"; fi
if [[ -z $out ]]; then fail_usage "--out must not be empty"; fi
out=$(realpath -m -- "$out")
if [[ -e $out && ! -d $out ]]; then fail_usage "--out '$out' is no directory"; fi
# Only a folder with this file is written to, and by one demo at a time: traces of two would be reported as one session.
mark=$out/.padr-demo
if [[ -d $out && ! -e $mark && -n $(ls -A -- "$out") ]]; then
  fail_usage "--out '$out' has files, and no .padr-demo, so that they are no demo's; name another folder"
fi
if ! mkdir -p -- "$out" || ! { exec 9>>"$mark"; }; then
  echo "$me: cannot write to $out: choose another folder with --out" >&2
  exit 1
fi
if ! flock --nonblock 9; then
  fail_usage "--out '$out': another demo is writing there; name another folder, or wait until it has ended"
fi

# --- set up and build: the same build folder and objects as tools/test.sh; tests only if they were asked for before. What the
# page needs comes first. The report is built while the peers play, with what processor time they leave.
alive() { kill -0 "$1" 2>/dev/null; }
build_log=
building=
build_programs() {
  local jobs=${PADR_JOBS:-$(nproc)} without_tests=()
  if ! [[ $jobs =~ ^[1-9][0-9]*$ ]]; then fail_usage "PADR_JOBS is '$jobs', must be a number from 1"; fi
  # What has to be compiled is preprocessed once and not twice.
  export CCACHE_DEPEND=1
  echo "== looking for packages that are missing (on a bare system they take about a minute)"
  # What only the report draws with can wait, unless somebody has to be asked for a password.
  if ((EUID == 0)); then tools/deps.sh build; else tools/deps.sh build run; fi
  build_log=$out/build.log
  if [[ ! -e build/release/CMakeCache.txt ]]; then without_tests=(-DPADR_TESTS=OFF); fi
  echo "== configuring build/release"
  if ! cmake --preset release "${without_tests[@]}" >"$build_log" 2>&1; then
    cat "$build_log" >&2
    exit 1
  fi
  local first=(padr-peer)
  if [[ $page != off ]]; then first+=(padr-monitor); fi
  echo "== building ${first[*]}$(how_long "$jobs")"
  NINJA_STATUS='   %f of %t after %e s: ' cmake --build build/release --parallel "$jobs" --target "${first[@]}"
  # In a session of its own, as peers are: Ctrl-C ends the play and not this.
  # shellcheck disable=SC2016  # it is the inner shell that expands
  setsid nice -n 19 bash -c 'tools/deps.sh build run && cmake --build build/release --parallel "$1" --target padr-report' \
    bash "$jobs" >"$build_log" 2>&1 </dev/null 9>&- &
  building=$!
}
# From nothing it takes about 280 s of one processor.
how_long() { # JOBS
  if [[ -x build/release/bin/padr-peer ]]; then return; fi
  echo ": about $(((280 / $1 + 59) / 60)) min on $1 processors, less where ccache knows the files"
}
await_report() {
  if [[ -z $building ]]; then return; fi
  if alive "$building"; then echo "== waiting for the report's program and packages"; fi
  if ! wait "$building"; then
    cat "$build_log" >&2
    echo "$me: padr-report could not be built, or its packages not be installed" >&2
    exit 1
  fi
  building=
}

as_shown() { if [[ $1 == "$PWD"/* ]]; then echo "${1#"$PWD"/}"; else echo "$1"; fi; } # PATH: as a user here would write it
if [[ $installed == no ]]; then
  cd "$here/.."
  build_programs
  bin=$PWD/build/release/bin
  # The programs find a scenario as they do without this script: by its name, and then as a file from the caller's folder.
  cd "$OLDPWD"
  monitor_command=$(as_shown "$bin/padr-monitor")
else
  bin=$here
  monitor_command=padr-monitor
fi
shown=$(as_shown "$out")

# What only the programs can judge, scenario and network, is tried before an older recording gives way.
shaped=()
if [[ -n $netem ]]; then shaped=(--netem "$netem"); fi
tried=0
words=$("$bin/padr-peer" --wait-peers 1 --slots "$peers" --scenario "$scenario" --technique "$technique" "${scene_flags[@]}" \
  "${shaped[@]}" --input rest --duration 0.02 --linger 0 2>&1) || tried=$?
if ((tried == 2)); then
  echo "$words" >&2
  exit 2
fi

# --- run
if compgen -G "$out/peer*.trace" >/dev/null; then echo "== the recording in $shown gives way to a new one"; fi
rm -f "$out"/peer*.trace "$out"/peer*.json "$out"/peer*.log "$out"/report.json "$out"/monitor.log "$out"/page
rm -f "$out"/plots/*.svg "$out"/plots/*.png "$out"/csv/*.csv

# A UDP port that no socket of this machine has, from the range below the one that the system hands out by itself.
free_port() {
  local port tries
  for ((tries = 0; tries < 100; ++tries)); do
    port=$((20000 + RANDOM % 12000))
    if ! in_use udp "$port"; then
      echo "$port"
      return
    fi
  done
  echo "$me: found no free UDP port" >&2
  return 1
}

pids=()
monitor=
stop_peers() {
  local pid tries
  for pid in "${pids[@]}"; do kill -TERM "$pid" 2>/dev/null || true; done
  for ((tries = 0; tries < 30; ++tries)); do
    for pid in "${pids[@]}"; do
      if alive "$pid"; then sleep 0.1; continue 2; fi
    done
    break
  done
  for pid in "${pids[@]}"; do kill -KILL "$pid" 2>/dev/null || true; done
  if [[ -n $monitor ]]; then kill -TERM "$monitor" 2>/dev/null || true; fi
  if ((${#pids[@]} > 0)) || [[ -n $monitor ]]; then wait "${pids[@]}" ${monitor:+"$monitor"} 2>/dev/null || true; fi
  pids=() monitor=
}
trap 'stop_peers; if [[ -n $building ]]; then kill -TERM -- "-$building" 2>/dev/null || true; fi' EXIT
# With a page the first Ctrl-C ends the play and not the report. Only this script gets it: programs run in sessions of
# their own.
enough=no
interrupted() {
  if [[ $enough == no && -n $monitor ]]; then
    enough=yes
    return 0
  fi
  printf '\n%s: stopped; logs: %s\n' "$me" "$shown/peer*.log" >&2
  exit 130
}
trap interrupted INT
trap 'exit 143' TERM

# --- the page: the monitor says where it can be found, and where peers are to tell it
told=()
start_monitor() {
  local tries where=
  # A process in the background opens its files when it gets to run, which may be after they are read here.
  : >"$out/monitor.log"
  setsid "$bin/padr-monitor" --listen "127.0.0.1:$page" --peers-listen 127.0.0.1:0 \
    >"$out/page" 2>"$out/monitor.log" </dev/null &
  monitor=$!
  for ((tries = 0; tries < 100; ++tries)); do
    where=$(sed -n 's/.*--monitor \(127[.]0[.]0[.]1:[0-9]*\)$/\1/p' "$out/monitor.log")
    if [[ -n $where && -s $out/page ]]; then break; fi
    if ! alive "$monitor"; then
      tail -n 3 "$out/monitor.log" >&2
      echo "$me: there is no page; choose another port with --page, or --page off" >&2
      exit 1
    fi
    sleep 0.1
  done
  told=(--monitor "$where" --control)
}
if [[ $page != off ]]; then start_monitor; fi

# Of a scene: the avatar of peer 0 takes a path, time after time where nothing is touched, the others stand. What is
# pushed away is pushed only once: with a page, after some seconds to open it.
if [[ $scene == proxy && $page != off ]]; then
  awk -F, -v OFS=, 'NR > 1 { if (NR == 2) print; $1 = sprintf("%.6f", $1 + 20) } 1' "$path" >"$out/path.csv"
  path=$out/path.csv
elif [[ -n $scene && $scene != proxy ]]; then
  path=$path,loop
fi
input_of() { # INDEX
  if [[ -z $scene ]]; then
    echo "wander:$((seed * 100 + $1))"
  elif (($1 == 0)); then
    echo "path:$path"
  else
    echo rest
  fi
}

port=$(free_port)
start_peer() { # INDEX
  local role=(--join "127.0.0.1:$port") shaped=()
  if (($1 == 0)); then role=(--listen "127.0.0.1:$port" --wait-peers "$peers"); fi
  if [[ -n $netem ]]; then shaped=(--netem "$netem" --netem-seed "$((seed * 100 + $1))"); fi
  : >"$out/peer$1.log"
  setsid "$bin/padr-peer" "${role[@]}" --scenario "$scenario" --seed "$seed" --technique "$technique" \
    "${scene_flags[@]}" "${shaped[@]}" --input "$(input_of "$1")" --duration "$duration" \
    --trace "$out/peer$1.trace" --json "$out/peer$1.json" "${told[@]}" >"$out/peer$1.log" 2>&1 </dev/null &
  pids+=($!)
}

until=
if [[ -t 1 && -n $monitor ]]; then until=", or until Ctrl-C"; fi
echo "== $peers peers play '$scenario' by '$technique' for $duration s$until, network: ${netem:-unimpaired}"
for ((i = 0; i < peers; ++i)); do start_peer "$i"; done
if [[ -n $monitor ]]; then
  echo
  echo "   Look and play along:  $(head -n 1 "$out/page")"
  echo
fi

# Joining through a bad network and draining the last updates take their time; past that a peer hangs.
limit=$((duration + 30))
started=$SECONDS
shown_at=-5
while :; do
  running=0
  for pid in "${pids[@]}"; do if alive "$pid"; then running=$((running + 1)); fi; done
  elapsed=$((SECONDS - started))
  if ((running == 0 || elapsed >= limit)); then break; fi
  if [[ $enough == yes ]]; then
    for pid in "${pids[@]}"; do kill -TERM "$pid" 2>/dev/null || true; done
    duration=$elapsed
    limit=$((elapsed + 30))
    enough=told
  fi
  # A peer that gave up early will not come back: no need to sit out the rest.
  if ((running < peers && elapsed < duration / 2)); then break; fi
  line="  $elapsed/$duration s, $running of $peers peers running"
  if [[ -t 1 ]]; then
    status=$(tail -n 1 "$out/peer0.log" | tr -d '\r')
    line="$line | $status"
    width=$(tput cols 2>/dev/null || echo 80)
    printf '\r\033[K%s' "${line:0:width-1}"
  elif ((elapsed >= shown_at + 5)); then
    echo "$line"
    shown_at=$elapsed
  fi
  sleep 0.5 || true # a Ctrl-C ends it as well
done
if [[ -t 1 ]]; then printf '\r\033[K'; fi

# --- judge
failed=()
for ((i = 0; i < peers; ++i)); do
  if alive "${pids[i]}"; then
    if ((elapsed >= limit)); then
      failed+=("peer $i was still running after $limit s: $shown/peer$i.log")
    fi
    continue
  fi
  status=0
  wait "${pids[i]}" || status=$?
  if ((status == 0 && elapsed < duration / 2)); then
    failed+=("peer $i ended after $elapsed of $duration s: $shown/peer$i.log")
  elif ((status != 0)); then
    failed+=("peer $i exited with status $status: $shown/peer$i.log")
    # The first ones tell the story.
    if ((${#failed[@]} <= 3)); then tail -n 5 "$out/peer$i.log" | sed "s/^/  peer $i: /" >&2; fi
  fi
done
stop_peers
if ((${#failed[@]} > 0)); then
  printf "$me: %s\\n" "${failed[@]}" >&2
  exit 1
fi

await_report
echo "== report"
verdict=0
"$bin/padr-report" "$out"/peer*.trace --plots "$out/plots" --csv "$out/csv" --json "$out/report.json" || verdict=$?
echo
echo "plots:  $shown/plots"
echo "tables: $shown/csv, $shown/report.json"
echo "traces: $shown/peer*.trace"
if [[ $page != off ]]; then echo "to see it again: $monitor_command --trace $shown"; fi
case $verdict in
  0) echo "All confirmed worlds were identical." ;;
  1) echo "CONFIRMED WORLDS DIFFERED; logs: $shown/peer*.log"; exit 1 ;;
  *) echo "$me: padr-report failed with status $verdict; traces and logs: $shown" >&2; exit 1 ;;
esac
