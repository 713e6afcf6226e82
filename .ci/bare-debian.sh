#!/usr/bin/env bash
# Proves that nothing has to be installed by hand: makes a bare Debian in a folder, clones this repository into it and
# runs tools/demo.sh and tools/test.sh there. Needs root and mmdebstrap, and takes its package sources, keys and proxy
# from the machine it runs on.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: .ci/bare-debian.sh [--suite NAME=bookworm] [--only STEPS=demo,test] [--duration S=15] [--keep]

  --suite NAME     Debian release to make; the sources are those of this machine with the release's name put in
  --only STEPS     comma separated, out of: deps, demo, test
  --duration S     length of the demo
  --keep           leave the folder for a look inside, and say where it is
  --with-changes   take the files as they are in the work tree, not as committed
TEXT
}

suite=bookworm
steps=demo,test
duration=15
keep=no
changes=no
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --keep) keep=yes ;;
    --with-changes) changes=yes ;;
    --suite | --only | --duration)
      if (($# < 2)); then echo "bare-debian.sh: $1 needs a value" >&2; exit 2; fi
      case $1 in
        --suite) suite=$2 ;;
        --only) steps=$2 ;;
        --duration) duration=$2 ;;
      esac
      shift ;;
    *) echo "bare-debian.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
  shift
done
for step in ${steps//,/ }; do
  case $step in
    deps | demo | test) ;;
    *) echo "bare-debian.sh: --only: '$step' is none of deps, demo, test" >&2; exit 2 ;;
  esac
done

if ((EUID != 0)); then echo "bare-debian.sh: needs root, for chroot" >&2; exit 1; fi
repo=$(cd "$(dirname "$0")/.." && pwd)
if ! command -v mmdebstrap >/dev/null || ! command -v git >/dev/null; then
  DEBIAN_FRONTEND=noninteractive apt-get -q update
  DEBIAN_FRONTEND=noninteractive apt-get -q install -y --no-install-recommends mmdebstrap git
fi

work=$(mktemp -d)
root=$work/root
mounted=()
cleanup() {
  local status=$? i
  for ((i = ${#mounted[@]} - 1; i >= 0; --i)); do umount -l "${mounted[i]}" || true; done
  if [[ $keep == yes ]]; then
    echo "bare-debian.sh: the system is in $root"
  elif ((${#mounted[@]} > 0)) && grep -qF " $root/" /proc/mounts; then
    echo "bare-debian.sh: something is still mounted below $root: not removed" >&2
  else
    rm -rf --one-file-system "$work"
  fi
  exit "$status"
}
trap cleanup EXIT
trap 'exit 130' INT TERM

"$repo/.ci/debian-sources.sh" sources "$suite" >"$work/sources.list"
"$repo/.ci/debian-sources.sh" settings >"$work/host.conf"

echo "bare-debian.sh: making a bare $suite"
mmdebstrap --quiet --mode=root --variant=minbase --aptopt="$work/host.conf" "$suite" "$root" - <"$work/sources.list"
cp /etc/resolv.conf "$root/etc/resolv.conf"
cp /etc/hosts "$root/etc/hosts"

for place in proc sys dev; do
  mount --rbind "/$place" "$root/$place"
  mount --make-rslave "$root/$place" 2>/dev/null || true
  mounted+=("$root/$place")
done

mkdir -p "$root/src"
git clone --quiet --no-hardlinks "$repo" "$root/src/padr"
if [[ $changes == yes ]]; then
  (cd "$repo" && git ls-files --cached --others --exclude-standard -z | tar --null --ignore-failed-read -cf - -T -) |
    tar -C "$root/src/padr" -xf -
fi

inside() { # COMMAND...
  chroot "$root" env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
    ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
    bash -c 'cd /src/padr && exec "$@"' bash "$@" </dev/null
}
echo "bare-debian.sh: $(inside dpkg-query -W -f '.' | wc -c) packages in it"
for step in ${steps//,/ }; do
  echo "bare-debian.sh: == $step"
  started=$SECONDS
  case $step in
    deps) inside tools/deps.sh all; inside tools/deps.sh all ;;
    demo) inside tools/demo.sh --duration "$duration" ;;
    test) inside tools/test.sh ;;
  esac
  echo "bare-debian.sh: == $step passed after $((SECONDS - started)) s"
done
