#!/usr/bin/env bash
# Makes the Debian package: programs, manual pages, completion for bash, the Wireshark plugin, documents.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/package.sh [--out DIR]

Installs missing packages (tools/deps.sh), builds the programs in build/release, and makes padr_VERSION_ARCHITECTURE.deb of
them. Install it with

  sudo apt install ./out/padr_*.deb

after which padr-demo shows four peers at play, and every program has a manual page.

  --out DIR   where the package goes   (default out)
  --help      this text

PADR_JOBS=N in the environment bounds the parallel build jobs.
TEXT
}
fail_usage() { echo "package.sh: $1 (see --help)" >&2; exit 2; }

out=out
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --out=*) out=${1#*=}; shift ;;
    --out)
      if (($# < 2)); then fail_usage "--out needs a value"; fi
      out=$2
      shift 2 ;;
    *) fail_usage "unknown argument '$1'" ;;
  esac
done
if [[ -z $out ]]; then fail_usage "--out must not be empty"; fi
out=$(realpath -m -- "$out")
if [[ -e $out && ! -d $out ]]; then fail_usage "--out '$out' is no directory"; fi
cd "$(dirname "$0")/.."
jobs=${PADR_JOBS:-$(nproc)}
if ! [[ $jobs =~ ^[1-9][0-9]*$ ]]; then fail_usage "PADR_JOBS is '$jobs', must be a number from 1"; fi

# What has to be compiled is preprocessed once and not twice.
export CCACHE_DEPEND=1
# The same commit makes the same files, whatever the day.
if [[ -z ${SOURCE_DATE_EPOCH:-} ]] && date=$(git log -1 --format=%ct 2>/dev/null) && [[ -n $date ]]; then
  export SOURCE_DATE_EPOCH=$date
fi
tools/deps.sh build package
mkdir -p "$out"
log=$(mktemp)
made=$(mktemp -d)
trap 'rm -rf "$log" "$made"' EXIT
quietly() { "$@" >"$log" 2>&1 || { cat "$log" >&2; echo "package.sh: failed: $*" >&2; exit 1; }; }

without_tests=()
if [[ ! -e build/release/CMakeCache.txt ]]; then without_tests=(-DPADR_TESTS=OFF); fi
echo "== configuring build/release"
quietly cmake --preset release "${without_tests[@]}" -DPADR_PACKAGE=ON
echo "== building"
cmake --build build/release --parallel "$jobs" --target padr_package_files
echo "== packing"
quietly cpack --config build/release/CPackConfig.cmake -G DEB -B "$made"
package=$(find "$made" -maxdepth 1 -name '*.deb')
mv -- "$package" "$out/"
package=$out/${package##*/}
echo "$package: $(($(stat -c %s "$package") / 1000)) kB, needs $(dpkg-deb -f "$package" Depends)"
echo "install it with: sudo apt install $package"
