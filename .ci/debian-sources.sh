#!/usr/bin/env bash
# Prints what another Debian system needs of this machine's apt: its Debian sources as lines of a sources.list, or its
# network settings. Third-party sources stay behind.
#
#   .ci/debian-sources.sh sources SUITE    the Debian sources, with the release's name put in
#   .ci/debian-sources.sh settings         proxy, retries and TLS settings, as an apt.conf
#   .ci/debian-sources.sh environment      NAME=VALUE of each variable that tells programs of the proxy
set -euo pipefail

case ${1:-} in
  sources)
    # shellcheck disable=SC1091  # every Debian has it
    host_suite=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
    lines() {
      # shellcheck disable=SC2016  # apt expands these
      apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian' |
        sort -u | sed "s/ $host_suite\\([ -]\\)/ $2\\1/"
    }
    if [[ -z $(lines "$@") ]]; then DEBIAN_FRONTEND=noninteractive apt-get -q update >&2; fi
    lines "$@" | grep . || { echo "debian-sources.sh: apt knows no Debian sources here" >&2; exit 1; } ;;
  settings) apt-config dump | grep -iE '^Acquire::([a-z]+::Proxy|Retries|https?::(Verify|CaInfo))' || true ;;
  environment)
    proxy=$(apt-config dump | sed -n 's/^Acquire::http::Proxy "\(.*\)";$/\1/Ip' | head -n 1)
    for word in http_proxy https_proxy no_proxy; do
      value=${!word:-}
      if [[ $word == http_proxy && -z $value ]]; then value=$proxy; fi
      if [[ -n $value ]]; then echo "$word=$value"; fi
    done ;;
  *) echo "debian-sources.sh: '${1:-}' is none of: sources SUITE, settings, environment" >&2; exit 2 ;;
esac
