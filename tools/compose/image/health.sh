#!/bin/sh
# The health check of a peer: it plays, its confirmed world advances, and it said so within the last seconds.
file=${PADR_DATA:-/data}/peer${PADR_NUMBER:?}.health
if [ -z "$(find "$file" -newermt '-5 seconds' 2>/dev/null)" ]; then
  echo "no sign of life in $file for 5 s"
  exit 1
fi
tr -d '\n' <"$file"
# A Swarm lets nobody find a service that is not healthy: there, a peer that waits for the others is well.
case ${PADR_TASK:-} in
  "" | "{{"*) grep -q '"healthy": true' "$file" ;;
  *) grep -q -e '"healthy": true' -e '"playing": false' "$file" ;;
esac
