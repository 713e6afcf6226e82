#!/usr/bin/env bash
# Programs for aarch64, cross-compiled here and run by qemu-user: what step `processors` compares with this machine's.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: .ci/aarch64.sh [--help] [--mistakes]

Makes build/aarch64/run, a folder with padr-lab (run and replay only), padr-peer, padr-capture and tests for aarch64, each
of which runs here.

  --mistakes   the programs seeded_*, too: each has a mistake that the physics fingerprint must show

The arm64 packages that they are compiled and run with are unpacked into padr/arm64 below XDG_CACHE_HOME or ~/.cache; this
system's own packages stay as they are. Installs what it needs (tools/deps.sh build aarch64 box2d). PADR_SYSROOT in the
environment names another folder for them.

Exit: 0 done, 77 not possible here, 1 failed.
TEXT
}
programs=(run_and_replay padr-peer padr-capture world_test)
for arg in "$@"; do
  case $arg in
    --help | -h) usage; exit 0 ;;
    --mistakes) programs+=(seeded_{right,fused,package,fast,sine,order,variable,memory,char}) ;;
    *) echo "aarch64.sh: unknown argument '$arg' (see --help)" >&2; exit 2 ;;
  esac
done

cd "$(dirname "$0")/.."
jobs=${PADR_JOBS:-$(nproc)}
suite=bookworm
impossible=77
if [[ $(uname -m) != x86_64 ]]; then
  echo "aarch64.sh: this is no x86-64 machine: nothing to compare with"
  exit "$impossible"
fi
tools/deps.sh build aarch64 box2d
for program in aarch64-linux-gnu-g++ qemu-aarch64-static mmdebstrap; do
  if ! command -v "$program" >/dev/null; then
    echo "aarch64.sh: no $program here, and no package that has it"
    exit "$impossible"
  fi
done

# The libraries, as arm64 has them, what they need, and what runs with them. Unpacked only: no script of theirs runs.
packages=libc6-dev,libstdc++6,libgcc-s1,libboost-dev,libprotobuf-dev,libsodium-dev,libspdlog-dev,libfmt-dev,libcli11-dev
packages+=,nlohmann-json3-dev,libjs-dygraphs,libminiupnpc-dev,libnatpmp-dev,libgtest-dev,libbox2d-dev
sysroot=${PADR_SYSROOT:-${XDG_CACHE_HOME:-$HOME/.cache}/padr/arm64}
contents="$suite $packages"
if [[ $(cat "$sysroot/contents" 2>/dev/null) != "$contents" ]]; then
  if ((EUID != 0)); then echo "aarch64.sh: needs root, once, to unpack the arm64 packages"; exit "$impossible"; fi
  echo "== unpacking the arm64 packages"
  mkdir -p "$(dirname "$sysroot")"
  work=$(mktemp -d -p "$(dirname "$sysroot")")
  trap 'rm -rf "$work"' EXIT
  .ci/debian-sources.sh sources "$suite" >"$work/sources.list"
  .ci/debian-sources.sh settings >"$work/host.conf"
  mmdebstrap --quiet --mode=root --variant=extract --architectures=arm64 --aptopt="$work/host.conf" --include="$packages" \
    "$suite" "$work/root" - <"$work/sources.list" >"$work/log" 2>&1 ||
    { tail -n 40 "$work/log" >&2; echo "aarch64.sh: mmdebstrap failed" >&2; exit 1; }
  echo "$contents" >"$work/root/contents"
  rm -rf --one-file-system "$sysroot"
  mv "$work/root" "$sysroot"
fi

echo "== building for aarch64"
export PADR_SYSROOT=$sysroot CCACHE_DEPEND=1 CCACHE_NOHASHDIR=1 CCACHE_BASEDIR=$PWD
cmake --preset aarch64 >build/aarch64.log 2>&1 || { cat build/aarch64.log >&2; exit 1; }
nice cmake --build build/aarch64 --parallel "$jobs" --target "${programs[@]}"

# Variables that nobody has set hold a pattern there (see CMakePresets.json), and so does memory: what reads one before it is
# set comes out otherwise than here.
rm -rf build/aarch64/run
mkdir build/aarch64/run
for program in "${programs[@]}"; do
  printf '#!/bin/sh\nexport MALLOC_PERTURB_=165\nexec qemu-aarch64-static -L "%s" -0 "%s" "%s" "$@"\n' "$sysroot" "$program" "$PWD/build/aarch64/bin/$program" \
    >"build/aarch64/run/$program"
  chmod +x "build/aarch64/run/$program"
done
mv build/aarch64/run/run_and_replay build/aarch64/run/padr-lab
