#!/usr/bin/env bash
# Makes the pictures in the README: docs/techniques.svg, four techniques on the same input, seed and links, and
# docs/monitor.png, the page of padr-monitor with four real peers (needs Chromium and Selenium).
# Usage: tools/picture.sh [BIN_DIR]   (default build/release/bin)
set -euo pipefail
cd "$(dirname "$0")/.."
bin=${1:-build/release/bin}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for technique in avatar-only fixed adaptive full; do
  "$bin/padr-lab" run --scenario arena --peers 4 --technique "$technique" --netem "delay 100ms 50ms loss 10%" \
    --seconds 60 --seed 3 --csv - >"$work/$technique.csv"
  # The mean of the peers, averaged over half a second.
  awk -F, 'NR > 1 { k = int($1 / 30); sum[k] += $5; n[k]++ }
           END { for (k in sum) print (k + 0.5) / 2, sum[k] / n[k] }' "$work/$technique.csv" | sort -n >"$work/$technique.dat"
done

gnuplot <<EOF
set terminal svg size 860,380 font "sans,13" background rgb "white"
set output "docs/techniques.svg"
set logscale y
set yrange [0.1:300]
set grid ytics lc rgb "#dddddd"
set border 3
set tics nomirror
set key outside right center samplen 2
set xlabel "session time (s)"
set ylabel "combined inconsistency (m)"
set title "4 peers, 100 ms +- 50 ms, 10 % loss: how far each view is from the truth, all entities summed"
plot "$work/avatar-only.dat" with lines lw 2 lc rgb "#D55E00" title "avatar-only", \\
     "$work/fixed.dat" with lines lw 2 lc rgb "#E69F00" title "fixed 0.5 m", \\
     "$work/adaptive.dat" with lines lw 2 lc rgb "#0072B2" title "adaptive 0.8:0.3 m", \\
     "$work/full.dat" with lines lw 3 lc rgb "#009E73" title "full"
EOF
echo "docs/techniques.svg"

python3 -B tests/browser/picture.py "$bin/padr-monitor" "$bin/padr-peer" docs
