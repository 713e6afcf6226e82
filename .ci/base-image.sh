#!/usr/bin/env bash
# Sees to it that the container engine has the Dockerfile's base image: as it is, pulled, or, where no registry is in
# reach, made here from this machine's Debian sources.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: .ci/base-image.sh [--local]

Does nothing if the engine has debian:bookworm-slim, else pulls it, else makes it with mmdebstrap (needs root).

  --local   do not try to pull
  --help    this text
TEXT
}

image=debian:bookworm-slim
suite=bookworm
pull=yes
for arg in "$@"; do
  case $arg in
    --help | -h) usage; exit 0 ;;
    --local) pull=no ;;
    *) echo "base-image.sh: unknown argument '$arg' (see --help)" >&2; exit 2 ;;
  esac
done

if docker image inspect "$image" >/dev/null 2>&1; then echo "base-image.sh: $image is there"; exit 0; fi
if [[ $pull == yes ]] && timeout 120 docker pull --quiet "$image" 2>/dev/null; then exit 0; fi

echo "base-image.sh: no registry gave $image: making it from this machine's Debian sources"
if ((EUID != 0)); then echo "base-image.sh: needs root for that" >&2; exit 1; fi
if ! command -v mmdebstrap >/dev/null; then
  echo "base-image.sh: no mmdebstrap here: run tools/deps.sh check" >&2
  exit 1
fi
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$here/debian-sources.sh" sources "$suite" >"$work/sources.list"
"$here/debian-sources.sh" settings >"$work/host.conf"

# Like the published image: the least of packages, no package lists, no documentation but licences. A
# system that is merged from the start needs no usrmerge, which would bring all of Perl.
# shellcheck disable=SC2016  # the hooks are for mmdebstrap to expand
mmdebstrap --quiet --mode=root --variant=minbase --aptopt="$work/host.conf" \
  --hook-dir=/usr/share/mmdebstrap/hooks/merged-usr \
  --setup-hook='printf "Package: usrmerge\nPin: version *\nPin-Priority: -1\n" >"$1"/etc/apt/preferences.d/merged' \
  --customize-hook='rm "$1"/etc/apt/preferences.d/merged' \
  --dpkgopt='path-exclude=/usr/share/man/*' \
  --dpkgopt='path-exclude=/usr/share/locale/*' \
  --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-exclude=/usr/share/info/*' \
  --dpkgopt='path-include=/usr/share/doc/*/copyright' \
  --customize-hook='rm -rf "$1"/var/lib/apt/lists/* "$1"/var/cache/* "$1"/var/log/* "$1"/etc/hostname "$1"/etc/resolv.conf' \
  --customize-hook='rm -f "$1"/etc/apt/apt.conf.d/99mmdebstrap' \
  "$suite" "$work/base.tar" - <"$work/sources.list" >"$work/log" 2>&1 ||
  { tail -n 40 "$work/log" >&2; echo "base-image.sh: mmdebstrap failed" >&2; exit 1; }
docker import --change 'CMD ["bash"]' --message "made by .ci/base-image.sh" "$work/base.tar" "$image" >/dev/null
echo "base-image.sh: made $image, $(($(docker image inspect --format '{{.Size}}' "$image") / 1000000)) MB"
