#!/usr/bin/env bash
# Installs the Debian packages this project needs, and only those that are missing. A second run does nothing.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/deps.sh [--list] [GROUP...]

Installs what is missing of the Debian packages of the named groups (default: build run test).

  build   compiler, CMake, Ninja and the libraries the programs are built on
  run     what the programs call at run time: gnuplot for plots, rsvg-convert for film strips
  test    GoogleTest, Google Benchmark, RapidCheck, Python; Chromium and Selenium, for the page of padr-monitor; tshark
          and tcpdump, for the Wireshark plugin and captures; iproute2 and nftables, for networks that fall apart and NATs
  check   formatting, linting, clang builds, fuzzing, the clean-clone check, Compose and a base image for containers,
          a router's miniupnpd
  aarch64 a compiler for that processor, and qemu, by which its programs run here
  docs    mkdocs and its theme, for the documents as a site; pandas, to read the data that the programs write
  package help2man and dpkg-dev, for tools/package.sh
  all     every group above
  box2d   the sources of the system's package of Box2D, unpacked into build/box2d: part of `build` on other processors than
          x86-64, where the package's floats are others (docs/determinism.md)
  pictures  what tools/pictures.sh puts the moving picture of the page together with: ffmpeg, gifsicle

  --list  print the packages of the groups and whether each is installed; install nothing
  --help  this text

Uses apt-get, through sudo when you are not root. On other systems it names the packages and goes on.
TEXT
}

# A word is a package, or alternatives in order of preference. '@' stands for the newest version number that the
# system offers: clang-14 is Debian 12's, later releases carry others.
packages_of() {
  case $1 in
    build) echo g++ cmake ninja-build ccache pkg-config libbox2d-dev libboost-dev protobuf-compiler \
      libprotobuf-dev libsodium-dev libspdlog-dev libfmt-dev libcli11-dev nlohmann-json3-dev libjs-dygraphs \
      libminiupnpc-dev libnatpmp-dev ;;
    run) echo 'gnuplot-nox|gnuplot-qt|gnuplot-x11' librsvg2-bin ;;
    test) echo libgtest-dev libbenchmark-dev librapidcheck-dev python3 chromium chromium-driver \
      python3-selenium tshark tcpdump iproute2 nftables ;;
    box2d) echo dpkg-dev ;;
    check) echo 'clang-14|clang-@' 'clang-format-14|clang-format-@' 'clang-tidy-14|clang-tidy-@' \
      'libclang-rt-14-dev|libclang-rt-@-dev' git shellcheck docker-compose mmdebstrap 'miniupnpd-nftables|miniupnpd' ;;
    aarch64) echo g++-aarch64-linux-gnu qemu-user-static mmdebstrap ;;
    docs) echo mkdocs mkdocs-material python3-pandas ;;
    package) echo help2man python3 dpkg-dev ;;
    pictures) echo ffmpeg gifsicle ;;
  esac
}

installed() { grep -qxF -- "$1" <<<"$present"; } # PACKAGE

# Prints the newest package name, installed (known to dpkg) or available (known to apt), that matches a '@' pattern.
newest() { # PATTERN dpkg|apt
  local escaped=${1//+/\\+}
  local regex="^${escaped/@/[0-9]+}\$"
  { if [[ $2 == dpkg ]]; then
      echo "$present"
    else
      apt-cache pkgnames "${1%%@*}"
    fi
  } | grep -E "$regex" | sort -V | tail -n 1 || true
}

# Prints the alternative of a word that is installed; nothing when none is.
installed_alternative() { # WORD
  local one
  for one in ${1//|/ }; do
    if [[ $one == *@* ]]; then one=$(newest "$one" dpkg); fi
    if [[ -n $one ]] && installed "$one"; then echo "$one"; return; fi
  done
}

# Prints the first alternative of a word that apt could install; nothing when there is none.
available_alternative() { # WORD
  local one
  for one in ${1//|/ }; do
    if [[ $one == *@* ]]; then one=$(newest "$one" apt); fi
    if [[ -n $one && $(apt-cache policy "$one" 2>/dev/null) =~ Candidate:\ [^\(] ]]; then echo "$one"; return; fi
  done
}

list=no
groups=()
for arg in "$@"; do
  case $arg in
    --help | -h) usage; exit 0 ;;
    --list) list=yes ;;
    build | run | test | check | aarch64 | docs | package | pictures | box2d) groups+=("$arg") ;;
    all) groups+=(build run test check aarch64 docs package) ;;
    *) echo "deps.sh: unknown argument '$arg' (groups: build run test check aarch64 docs package all pictures box2d; see --help)" >&2; exit 2 ;;
  esac
done
if ((${#groups[@]} == 0)); then groups=(build run test); fi

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "deps.sh: this is no Debian-like system; make sure that what these packages hold is installed:" >&2
  for group in "${groups[@]}"; do echo "  $group: $(packages_of "$group")" >&2; done
  exit 0
fi

# The package was compiled with the compiler's default, which fuses multiplications and additions wherever all processors of
# an architecture can. Those of x86-64 cannot.
architecture=$(dpkg --print-architecture)
if [[ $architecture != amd64 && " ${groups[*]} " == *" build "* ]]; then groups+=(box2d); fi

# The names of installed packages. A system may have a package of other architectures, too, or of those alone: only this
# machine's count.
present=$(dpkg-query -W -f '${db:Status-Status} ${Architecture} ${Package}\n' | sed -n "s/^installed \($architecture\|all\) //p")
words=()
for group in "${groups[@]}"; do
  for word in $(packages_of "$group"); do
    if [[ $word == libbox2d-dev && $architecture != amd64 ]]; then continue; fi
    words+=("$group:$word")
  done
done
sources=no
if [[ " ${groups[*]} " == *" box2d "* ]]; then sources=yes; fi
box2d=$(cd "$(dirname "$0")/.." && pwd)/build/box2d

if [[ $list == yes ]]; then
  for entry in "${words[@]}"; do
    have=$(installed_alternative "${entry#*:}")
    printf '%-6s %-36s %s\n' "${entry%%:*}" "${entry#*:}" "${have:+installed: $have}"
  done
  if [[ $sources == yes ]]; then
    printf '%-6s %-36s %s\n' box2d "(sources of box2d)" "$(if [[ -e $box2d ]]; then echo "installed: build/box2d"; fi)"
  fi
  exit 0
fi

missing=()
for entry in "${words[@]}"; do
  if [[ -z $(installed_alternative "${entry#*:}") ]]; then missing+=("$entry"); fi
done
if [[ -e $box2d ]]; then sources=no; fi
if ((${#missing[@]} == 0)) && [[ $sources == no ]]; then exit 0; fi

as_root=()
if ((EUID != 0)) && ((${#missing[@]} > 0)); then
  if ! command -v sudo >/dev/null; then
    echo "deps.sh: missing: ${missing[*]#*:}" >&2
    echo "deps.sh: not root and no sudo here; as root, run: tools/deps.sh ${groups[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
apt_get() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 "$@" </dev/null
}

updated=no
update_lists() {
  echo "deps.sh: updating the package lists"
  apt_get update
  updated=yes
}

# Sets `wanted` to what apt shall install for the missing words and `unknown` to the words it has nothing for.
resolve() {
  local entry name
  wanted=()
  unknown=()
  for entry in "${missing[@]}"; do
    name=$(available_alternative "${entry#*:}")
    if [[ -n $name ]]; then wanted+=("$name"); else unknown+=("$entry"); fi
  done
}

# Lists of source packages of our own, of the system's Debian archives: the system's sources stay as they are. Needs no root.
get_box2d() {
  local work options keyring=/usr/share/keyrings/debian-archive-keyring.gpg
  work=$(mktemp -d)
  # shellcheck disable=SC2064 # the folder is known now
  trap "rm -rf '$work'" EXIT
  chmod 755 "$work" # apt reads what it downloads as another user
  mkdir -p "$work"/{lists,archives,box2d}/partial "${box2d%/*}"
  if [[ -e $keyring ]]; then keyring="[signed-by=$keyring] "; else keyring=""; fi
  # shellcheck disable=SC2016 # apt expands these
  apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian' |
    sort -u | sed "s|^|deb-src $keyring|" >"$work/sources.list"
  if [[ ! -s $work/sources.list ]]; then
    echo "deps.sh: apt knows no Debian archive here; unpack the sources of Box2D 2.4.1 into $box2d" >&2
    return 1
  fi
  options=(-q -o Dir::Etc::SourceList="$work/sources.list" -o Dir::Etc::SourceParts=/dev/null -o Dir::State::Lists="$work/lists"
    -o Dir::Cache="$work" -o Acquire::Languages=none -o Acquire::Retries=3)
  echo "deps.sh: getting the sources of box2d"
  apt-get "${options[@]}" update </dev/null &&
    (cd "$work/box2d" && apt-get "${options[@]}" -o APT::Sandbox::User=root source --download-only box2d </dev/null &&
      dpkg-source --no-check -x ./*.dsc sources) && # apt has checked it
    mv "$work/box2d/sources" "$box2d"
}

if ((${#missing[@]} == 0)); then
  get_box2d
  exit
fi

resolve
if ((${#unknown[@]} > 0)); then
  update_lists
  resolve
fi

needed=no
for entry in "${unknown[@]}"; do
  if [[ ${entry%%:*} == check || ${entry%%:*} == aarch64 ]]; then
    echo "deps.sh: no package ${entry#*:} on this system: skipped, the checks that use it are skipped too" >&2
  else
    echo "deps.sh: no package ${entry#*:} on this system (group ${entry%%:*})" >&2
    needed=yes
  fi
done
if [[ $needed == yes ]]; then exit 1; fi
install() {
  if ((${#wanted[@]} == 0)); then return; fi
  echo "deps.sh: installing ${wanted[*]}"
  if apt_get install -y --no-install-recommends "${wanted[@]}"; then return; fi
  # Lists that are older than the archive name files that are gone.
  if [[ $updated == yes ]]; then
    echo "deps.sh: apt-get could not install: ${wanted[*]}" >&2
    return 1
  fi
  update_lists
  resolve
  apt_get install -y --no-install-recommends "${wanted[@]}"
}
install
if [[ $sources == yes ]]; then get_box2d; fi
