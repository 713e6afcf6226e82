#!/usr/bin/env bash
# Runs inside a bare Debian, as root: installs /package/padr_*.deb and looks at what is promised of it.
set -euo pipefail
fail() { echo "installed.sh: $1" >&2; exit 1; }
began() { echo "== $1 (${SECONDS} s)"; }

began "installing"
rm -f /etc/dpkg/dpkg.cfg.d/* # images leave out manual pages
export DEBIAN_FRONTEND=noninteractive
# Only root may enter the folders that containers are given.
cp /package/padr_*.deb /var/cache/
packages_before=$(dpkg-query -W | wc -l)
apt-get -q update
apt-get -q install -y --no-install-recommends /var/cache/padr_*.deb
echo "$(($(dpkg-query -W | wc -l) - packages_before)) packages in $SECONDS s"
dpkg-query -L padr | sort >/var/cache/files
programs=$(sed -n 's,^/usr/bin/,,p' /var/cache/files)
[[ $(wc -w <<<"$programs") == 7 ]] || fail "other programs than seven: $programs"

began "programs, manual pages, completion"
for program in $programs; do
  "$program" --version
  zcat "/usr/share/man/man1/$program.1.gz" | grep '^\.SH OPTIONS' >/dev/null || fail "no manual page of $program with options"
  (
    # shellcheck disable=SC1090
    source "/usr/share/bash-completion/completions/$program"
    COMP_WORDS=("$program" --v) COMP_CWORD=1
    "_${program//-/_}"
    [[ ${COMPREPLY[0]} == --version ]]
  ) || fail "no completion of $program"
done
[[ -s /usr/share/man/man1/padr-lab-sweep.1.gz ]] || fail "no manual page of padr-lab sweep"
for file in copyright README.md CHANGELOG.md docs/idea.md; do
  [[ -s /usr/share/doc/padr/$file ]] || fail "no $file"
done

began "the demo, by somebody without rights, without and with a page"
useradd --create-home somebody
as_somebody() { (cd ~somebody && setpriv --reuid=somebody --regid=somebody --clear-groups env HOME="$PWD" "$@"); }
as_somebody padr-demo --duration 5 --page off | tail -n 4
[[ -s ~somebody/out/demo/report.json ]] || fail "no report of the demo"
: >/var/cache/said # there before the first look into it
as_somebody padr-demo --duration 6 --page 0 >/var/cache/said 2>&1 &
demo=$!
port=
for ((tries = 0; tries < 200; ++tries)); do
  port=$(sed -n 's,.*http://127[.]0[.]0[.]1:\([0-9]*\)/.*,\1,p' /var/cache/said)
  if [[ -n $port ]]; then break; fi
  sleep 0.1
done
[[ -n $port ]] || fail "the demo does not say where its page is: $(cat /var/cache/said)"
exec 3<>"/dev/tcp/127.0.0.1/$port"
printf 'GET / HTTP/1.1\r\nHost: 127.0.0.1:%s\r\nConnection: close\r\n\r\n' "$port" >&3
page=$(tr -d '\0' <&3)
exec 3>&-
[[ $page == "HTTP/1.1 200"*"<title>"*"</html>"* ]] || fail "that is no page: ${page:0:300}"
wait "$demo" || fail "the demo with a page failed: $(cat /var/cache/said)"
[[ -z $(find / -xdev -newer /var/cache/said -path '/usr/*' -type f) ]] || fail "the demo wrote below /usr"
as_somebody padr-demo --scene stop-short --page off --duration 3 | grep '^All confirmed worlds were identical' >/dev/null || fail "no scene"

began "Wireshark's plugin"
apt-get -q install -y --no-install-recommends tshark >/var/cache/tshark.log 2>&1 || { tail -n 20 /var/cache/tshark.log; fail "no tshark"; }
cd /var/cache
as_somebody bash -c '
  padr-peer --listen 127.0.0.1:29641 --wait-peers 2 --duration 2 --status-interval 0 --pcap play.pcapng &
  padr-peer --join 127.0.0.1:29641 --duration 2 --status-interval 0
  wait $!' >play.log 2>&1 || { cat play.log; fail "two peers did not play"; }
as_somebody tshark -r play.pcapng -Y padr.tick -T fields -e padr.peer -e padr.tick >ticks 2>tshark.log
(($(wc -l <ticks) > 20)) || { head -n 5 ticks tshark.log; fail "tshark does not read datagrams"; }
as_somebody tshark -r play.pcapng -V 2>/dev/null | grep 'Field([0-9]*): link = ' >/dev/null || fail "tshark does not find wire.proto"

began "removing"
apt-get -q purge -y padr >/dev/null
while read -r path; do
  if [[ -e $path ]] && ! dpkg-query -S "$path" >/dev/null 2>&1 && [[ $path != /. ]]; then fail "left behind: $path"; fi
done </var/cache/files
[[ -z $(find / -xdev -name '*padr*' -not -path '/var/cache/*' -not -path '/package/*' -not -path '*/somebody/out/*') ]] || fail "something is left behind: $(find / -xdev -name '*padr*' -not -path '/var/cache/*')"
began "all is as promised"
