#!/bin/sh
# Measures what loss does to two techniques, and writes loss.csv beside this file. It is not enough yet.
cd "$(dirname "$0")" || exit 1
padr-lab sweep --technique fixed,full --peers 4 --delay 50ms --loss 0,10% --seeds 1-2 --seconds 20 --csv loss.csv
