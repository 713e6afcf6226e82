#!/usr/bin/env bash
# Takes the pictures of the page anew: docs/monitor.png, and docs/side-by-side.gif, in which one scene is played by `fixed`
# and by `full`.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/pictures.sh [monitor] [side-by-side]

Installs missing packages (tools/deps.sh build test pictures), builds the programs, and takes the named pictures of the
page in a Chromium without a screen; without names, both.

  monitor        docs/monitor.png: four live peers on a bad network
  side-by-side   docs/side-by-side.gif: what one of four peers sees, 8 s of the same scene by `fixed` and by `full`. Seed,
                 network and peer are fixed; the programs alone decide what is on it

  --help         this text
TEXT
}

pictures=()
for arg in "$@"; do
  case $arg in
    --help | -h) usage; exit 0 ;;
    monitor | side-by-side) pictures+=("$arg") ;;
    *) echo "pictures.sh: unknown argument '$arg' (pictures: monitor side-by-side; see --help)" >&2; exit 2 ;;
  esac
done
if ((${#pictures[@]} == 0)); then pictures=(monitor side-by-side); fi

cd "$(dirname "$0")/.."
export CCACHE_DEPEND=1
tools/deps.sh build test pictures
cmake --preset release >/dev/null
cmake --build build/release --parallel "${PADR_JOBS:-$(nproc)}" --target padr-peer padr-monitor padr-lab
bin=$PWD/build/release/bin
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

take_monitor() {
  tests/browser/picture.py "$bin/padr-monitor" "$bin/padr-peer" "$work"
  cp "$work/monitor.png" docs/monitor.png
}

take_side_by_side() {
  local technique
  for technique in fixed full; do
    "$bin/padr-lab" run --scenario clutter --technique "$technique" --peers 4 --seconds 29 --seed 1 --fidelity off \
      --netem "delay 100ms 50ms loss 10%" --trace "$work/$technique" >/dev/null
  done
  tests/browser/side_by_side.py "$bin/padr-monitor" "$bin/padr-peer" "$work/frames" "$work/fixed" "$work/full" \
    "100 ms ± 50 ms one way, 10 % lost"
  # Flat colours need no more than 64, and no dithering.
  ffmpeg -y -loglevel error -framerate 12 -i "$work/frames/frame-%03d.png" -vf \
    "split[a][b];[a]palettegen=max_colors=64[p];[b][p]paletteuse=dither=none:diff_mode=rectangle" "$work/all.gif"
  gifsicle -O3 --lossy=40 "$work/all.gif" -o docs/side-by-side.gif
}

for picture in "${pictures[@]}"; do
  "take_${picture//-/_}"
  ls -l docs/"$picture".*
done
