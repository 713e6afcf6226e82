#!/usr/bin/env bash
# Makes the Debian package and installs it in a bare Debian, where what it promises is looked at: the demo from the installed
# programs, manual pages, completion, the Wireshark plugin, and that nothing is left when it is gone. Exits with 77 where no
# container engine runs.
set -euo pipefail
cd "$(dirname "$0")/.."
out=out/ci/package
rm -rf "$out"
mkdir -p "$out"
tools/package.sh --out "$out"

if ! docker info >/dev/null 2>&1; then
  echo "no container engine answers 'docker info': the package has been made, and not installed"
  exit 77
fi
if ! docker image inspect debian:bookworm-slim >/dev/null 2>&1; then
  exec 9>out/ci/images.lock
  flock 9 # another step may be making it
  .ci/base-image.sh
  exec 9>&-
fi
way_out=()
while read -r setting; do way_out+=(--env "$setting"); done < <(.ci/debian-sources.sh environment)
name=padr-package-$$
trap 'docker rm --force "$name" >/dev/null 2>&1 || true' EXIT
trap 'exit 143' TERM
trap 'exit 130' INT
docker run --rm --name "$name" --network host "${way_out[@]}" --volume "$PWD/$out:/package:ro" \
  --volume "$PWD/tests/package/installed.sh:/installed.sh:ro" debian:bookworm-slim bash /installed.sh
