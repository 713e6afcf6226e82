#!/usr/bin/env python3
"""End to end behind a real router daemon: --map-port opens the NAT, so that a newcomer joins a founder behind it.

miniupnpd maps ports in a network namespace of its own, by NAT-PMP or by UPnP. Skipped where that is not permitted, or
where there is no miniupnpd.

Usage: peer_map_port.py PATH_TO_PADR_PEER [unittest arguments]
"""

import contextlib
import os
import shutil
import socket
import struct
import subprocess
import threading
import time

from hosts import main_unless
from internet import DOES_NOT, KINDS, Internet, seen, why_no_internet
from peers import PLAYING, Case
from waiting import wait_until

# A router that is sold offers no mapping if its own address is none of the Internet's.
OUTSIDE, NEIGHBOUR = "20.0.0.1", "20.0.0.2"
KEY = "11" * 32
SECONDS = 5
RULES = """
table inet daemon {
  chain forward {
    type filter hook forward priority -10;
    jump miniupnpd
  }
  chain miniupnpd {
  }
  chain prerouting {
    type nat hook prerouting priority -110;
    jump prerouting_miniupnpd
  }
  chain prerouting_miniupnpd {
  }
  chain postrouting {
    type nat hook postrouting priority 90;
    jump postrouting_miniupnpd
  }
  chain postrouting_miniupnpd {
  }
}
"""
CONFIGURATION = """
ext_ifname=outside
ext_ip={outside}
listening_ip=inside
port=0
enable_natpmp={natpmp}
enable_upnp={upnp}
secure_mode=yes
uuid=00000000-0000-0000-0000-000000000001
upnp_table_name=daemon
upnp_nat_table_name=daemon
upnp_forward_chain=miniupnpd
upnp_nat_chain=prerouting_miniupnpd
upnp_nat_postrouting_chain=postrouting_miniupnpd
lease_file={folder}/leases
allow 1024-65535 192.168.0.0/24 1024-65535
deny 0-65535 0.0.0.0/0 0-65535
"""


class MapPort(Case):
    def setUp(self):
        super().setUp()
        self.internet = Internet()
        self.addCleanup(self.internet.remove)
        self.internet.add_home("home", KINDS["port-restricted"], "a")
        self.router = "homer0"
        self.internet.ip(self.router, "addr", "add", f"{OUTSIDE}/24", "dev", "outside")
        self.internet.ip("founder", "addr", "add", f"{NEIGHBOUR}/24", "dev", "outside")
        self.internet.run(self.router, "nft", "-f", "-", text=RULES + "add rule ip firewall input iifname \"inside\" accept\n")

    @contextlib.contextmanager
    def daemon(self, natpmp, upnp):
        configuration = os.path.join(self.folder.name, "miniupnpd.conf")
        with open(configuration, "w", encoding="ascii") as f:
            f.write(CONFIGURATION.format(outside=OUTSIDE, natpmp=natpmp, upnp=upnp, folder=self.folder.name))
        command = ["miniupnpd", "-d", "-f", configuration, "-P", os.path.join(self.folder.name, "pid")]
        with open(os.path.join(self.folder.name, "daemon.log"), "w+", encoding="utf-8") as log:
            daemon = subprocess.Popen(command, stdout=log, stderr=log, preexec_fn=self.internet.enter(self.router))
            try:
                time.sleep(1)  # it says nothing when it is ready
                self.assertIsNone(daemon.poll(), "miniupnpd runs")
                yield log
            finally:
                daemon.terminate()
                daemon.wait(10)

    def start(self, machine, *arguments):
        return self.peer(*arguments, "--duration", SECONDS, env={**os.environ, "PADR_KEY": KEY},
                         preexec_fn=self.internet.enter(machine))  # fmt: skip

    def mappings(self):
        return self.internet.run(self.router, "nft", "list", "chain", "inet", "daemon", "prerouting_miniupnpd")

    def check(self, protocol):
        with (
            self.internet.socket("a") as inside,
            self.internet.socket("founder", NEIGHBOUR) as neighbour,
        ):
            inside_port = inside.getsockname()[1]
            self.assertIsNone(seen(neighbour, inside, (OUTSIDE, inside_port), DOES_NOT), "nothing comes in by itself")
        founder = self.start("a", "--listen", "0.0.0.0:7001", "--map-port", "--wait-peers", 2)
        said = founder.wait_for(r"the router forwards ([\d.]+):(\d+) to this peer, by (\S+)")
        self.assertEqual((said[1], said[3]), (OUTSIDE, protocol))
        self.assertIn("7001", self.mappings())
        newcomer = self.start("founder", "--listen", f"{NEIGHBOUR}:0", "--join", f"{OUTSIDE}:{said[2]}")
        newcomer.wait_for(PLAYING)
        self.assertEqual([p.end() for p in (founder, newcomer)], [0, 0])
        self.check_agreement([founder, newcomer], least_common=SECONDS - 2)
        wait_until(lambda: "7001" not in self.mappings(), "the mapping is taken back")

    def test_by_nat_pmp(self):
        with self.daemon("yes", "no"):
            self.check("NAT-PMP")

    def test_by_upnp(self):
        with self.daemon("no", "yes"):
            self.check("UPnP")

    @contextlib.contextmanager
    def slow_router(self, seconds):
        """Answers NAT-PMP (RFC 6886), each request so long after it came."""
        with self.internet.inside(self.router):
            s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        s.bind(("192.168.0.1", 5351))
        s.settimeout(0.1)
        ended = threading.Event()

        def answer():
            waiting = []
            while not ended.is_set():
                with contextlib.suppress(TimeoutError):
                    waiting.append((time.monotonic() + seconds, *s.recvfrom(64)))
                while waiting and waiting[0][0] <= time.monotonic():
                    _, request, asker = waiting.pop(0)
                    head = struct.pack("!BBHI", 0, 128 + request[1], 0, 1)
                    s.sendto(head + (socket.inet_aton(OUTSIDE) if request[1] == 0 else request[4:12]), asker)

        thread = threading.Thread(target=answer)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            s.close()

    # Such a router is asked twice for its address, and its second answer was taken for the mapping.
    def test_a_router_that_answers_slowly(self):
        with self.slow_router(0.35):
            peer = self.start("a", "--listen", "0.0.0.0:7001", "--map-port", "--wait-peers", 1)
            said = peer.wait_for(r"the router forwards ([\d.]+):(\d+) to this peer, by (\S+)")
            self.assertEqual((said[1], said[2], said[3]), (OUTSIDE, "7001", "NAT-PMP"))
            self.assertEqual(peer.end(), 0)

    def test_without_a_router_that_maps(self):
        peer = self.start("a", "--listen", "0.0.0.0:7001", "--map-port", "--wait-peers", 1)
        peer.wait_for("no router maps ports here")
        self.assertEqual(peer.end(), 0)


def why_not():
    if shutil.which("miniupnpd") is None:
        return "there is no program 'miniupnpd' (Debian: miniupnpd-nftables)"
    return why_no_internet()


if __name__ == "__main__":
    main_unless(why_not())
