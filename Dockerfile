# The programs in containers; docker-compose.yml says how they play together. Needs no BuildKit.
#
#   docker build --target capture .   tcpdump, for a side-car
#   docker build --target tc .        the kernel's netem, for a side-car
#   docker build --target firewall .  the kernel's firewall and NAT, for a side-car
#   docker build .                    every program of the project
#
# A way out to the Debian archive that your network needs (--network host, --build-arg http_proxy=...) is for the command
# line to say.

FROM debian:bookworm-slim AS capture
RUN apt-get -q update && apt-get -q install -y --no-install-recommends tcpdump && rm -rf /var/lib/apt/lists/* /var/cache/* \
  && groupadd --gid 10001 padr && useradd --uid 10001 --gid padr --no-create-home --home-dir /data padr \
  && install -d -o padr -g padr -m 0775 /data
COPY tools/compose/image/capture.sh /usr/local/bin/compose-capture
CMD ["compose-capture"]


FROM debian:bookworm-slim AS tc
RUN apt-get -q update && apt-get -q install -y --no-install-recommends iproute2 && rm -rf /var/lib/apt/lists/* /var/cache/*
COPY tools/compose/image/tc.sh /usr/local/bin/compose-tc
CMD ["compose-tc"]


FROM debian:bookworm-slim AS firewall
RUN apt-get -q update && apt-get -q install -y --no-install-recommends nftables && rm -rf /var/lib/apt/lists/* /var/cache/*
COPY tools/compose/image/firewall.sh /usr/local/bin/compose-firewall
CMD ["compose-firewall"]


FROM debian:bookworm-slim AS build
WORKDIR /src
ENV CCACHE_DIR=/ccache CCACHE_BASEDIR=/src CCACHE_NOHASHDIR=1 CCACHE_DEPEND=1
COPY tools/deps.sh tools/
RUN tools/deps.sh build && rm -rf /var/lib/apt/lists/*
COPY CMakeLists.txt CMakePresets.json ./
COPY cmake cmake
COPY proto proto
COPY common common
COPY shell shell
COPY peer peer
COPY tools tools
ARG JOBS=2
ARG PADR_REVISION=""
# Where ccache may find what others have compiled already, such as http://HOST:PORT, if their language was this one.
ARG CCACHE_REMOTE_STORAGE=""
ENV LANG=C.UTF-8
RUN cmake --preset release -DPADR_TESTS=OFF -DPADR_REVISION="$PADR_REVISION" \
  && cmake --build build/release --parallel "$JOBS" && ccache --show-stats && rm -rf /ccache
# The programs, and by what packages they get their libraries.
RUN install -D -s -t /out/bin build/release/bin/* \
  && ldd /out/bin/* | sed -n 's/.*=> \(\/[^ ]*\).*/\1/p' | sort -u \
  | while read -r library; do dpkg-query -S "$library" "/usr$library" 2>/dev/null; done \
  | cut -d: -f1 | sort -u >/out/packages && test -s /out/packages


FROM debian:bookworm-slim AS runtime
COPY --from=build /out/packages /packages
RUN apt-get -q update && xargs apt-get -q install -y --no-install-recommends </packages \
  && rm -rf /packages /var/lib/apt/lists/* /var/cache/* \
  && groupadd --gid 10001 padr && useradd --uid 10001 --gid padr --no-create-home --home-dir /data padr \
  && install -d -o padr -g padr -m 0775 /data
COPY --from=build /out/bin/ /usr/local/bin/
COPY tools/compose/image/peer.sh /usr/local/bin/compose-peer
COPY tools/compose/image/health.sh /usr/local/bin/compose-health
COPY tools/compose/image/report.sh /usr/local/bin/compose-report
USER padr
WORKDIR /data
CMD ["padr-peer", "--help"]
