#!/usr/bin/env bash
# Builds the documents as a site, to be read in a browser without a network.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
  cat <<'TEXT'
usage: tools/docs.sh [--serve [PORT] | --check]

Installs missing packages (mkdocs and its theme) and builds the documents as a site in out/site. Open out/site/index.html; the
search needs --serve, as browsers let no script read files.

  --serve [PORT]  build, then serve the site at http://127.0.0.1:PORT and build again when a page changes  (default 8000)
  --check         build, then follow every link of the built pages, and look for anything that would be asked of other machines
  --help          this text

The site asks nothing of other machines. Its pages are the repository's own files; mkdocs.yml has their order.

Exit status: 0 when all is well; 1 when the site cannot be built or a link leads nowhere; 2 for wrong arguments.
TEXT
}

wrong() { echo "docs.sh: $1; see --help" >&2; exit 2; }

mode=build
port=8000
while (($# > 0)); do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --check) mode=check ;;
    --serve)
      mode=serve
      if [[ ${2:-} =~ ^[0-9]+$ ]]; then port=$2; shift; fi
      if ((10#$port < 1 || 10#$port > 65535)); then wrong "port $port: allowed are 1 to 65535"; fi ;;
    *) wrong "unknown argument '$1' (--serve, --check)" ;;
  esac
  shift
done

tools/deps.sh docs
python3 -B tools/docs/pages.py assemble out/site-source
export PYTHONPATH=$PWD/tools/docs PYTHONDONTWRITEBYTECODE=1
if [[ $mode == serve ]]; then exec mkdocs serve --dev-addr "127.0.0.1:$port"; fi
mkdocs --quiet build --strict --clean
if [[ $mode == check ]]; then python3 -B tools/docs/built.py out/site; fi
echo "docs.sh: the site is in out/site; open out/site/index.html, or tools/docs.sh --serve"
