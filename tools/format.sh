#!/usr/bin/env bash
# Checks or fixes the formatting of the C++ files that git knows or could know (ignored files are left alone).
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tools/format.sh [--check | --fix] [FILE...]

  --check  name the files that clang-format would change, exit 1 if there are any (the default)
  --fix    rewrite them

Without FILE: all C++ files of the repository.
TEXT
}

mode=check
files=()
for arg in "$@"; do
  case $arg in
    --help | -h) usage; exit 0 ;;
    --check) mode=check ;;
    --fix) mode=fix ;;
    -*) echo "format.sh: unknown argument '$arg' (see --help)" >&2; exit 2 ;;
    *) files+=("$(realpath -- "$arg")") ;;
  esac
done

cd "$(dirname "$0")/.."
# Versions of clang-format disagree in details: 14 is the one that counts, another is better than none.
tool=$(compgen -c clang-format- | grep -xE 'clang-format-[0-9]+' | sort -V | tail -n 1 || true)
if command -v clang-format-14 >/dev/null; then tool=clang-format-14; fi
if [[ -z $tool ]]; then echo "format.sh: no clang-format here: run tools/deps.sh check" >&2; exit 1; fi

if ((${#files[@]} == 0)); then
  while IFS= read -r -d '' file; do
    if [[ -f $file ]]; then files+=("$file"); fi
  done < <(git ls-files -z --cached --others --exclude-standard '*.h' '*.cpp')
fi
if ((${#files[@]} == 0)); then exit 0; fi

if [[ $mode == fix ]]; then
  "$tool" -i -- "${files[@]}"
  exit 0
fi
bad=0
for file in "${files[@]}"; do
  if ! "$tool" --dry-run --Werror -- "$file" 2>/dev/null; then
    echo "not formatted: $file"
    bad=$((bad + 1))
  fi
done
echo "$tool: ${#files[@]} files, $bad to be formatted"
if ((bad > 0)); then
  echo "tools/format.sh --fix does it" >&2
  exit 1
fi
