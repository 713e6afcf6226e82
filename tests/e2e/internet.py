"""An Internet of network namespaces and nftables, with NATs of every kind, for end-to-end tests."""

import dataclasses
import itertools
import json
import os
import shutil
import socket
import subprocess

from hosts import Network, why_no_namespaces

FOUNDER, FOUNDER_TOO = "198.51.100.1", "198.51.100.2"  # one machine
FOUNDER_V6 = "2001:db8::1"

# What every router does: it lets out what is from inside, and in what answers that. Like routers that are sold, and unlike
# Linux by itself, it drops the rest without a trace: an answer by the router would keep the port from the machine behind.
ROUTER = """
table ip firewall {
  chain input {
    type filter hook input priority filter; policy drop;
  }
  chain forward {
    type filter hook forward priority filter; policy drop;
    iifname "inside" accept
    ct state established,related accept
    ct status dnat accept
  }
}
"""
KEEPS_PORTS = """
table ip nat {
  chain out {
    type nat hook postrouting priority srcnat;
    oifname "outside" masquerade
  }
}
"""
LETS_ALL_IN = """
table ip nat {
  chain in {
    type nat hook prerouting priority dstnat;
    iifname "outside" meta l4proto udp dnat to 192.168.0.2
  }
}
"""
DRAWS_PORTS = """
table ip nat {
  chain out {
    type nat hook postrouting priority srcnat;
    oifname "outside" masquerade random,fully-random
  }
}
"""
# What comes to a member from others than the founder. Homes have the same addresses: what one member sends to the other one's
# own address may come to itself.
COUNTS = """
table inet counts {
  counter direct {
  }
  chain input {
    type filter hook input priority filter;
    iifname "lo" accept
    ip saddr { 198.51.100.1, 198.51.100.2 } accept
    ip6 saddr 2001:db8::1 accept
    meta l4proto udp counter name direct
  }
}
"""


@dataclasses.dataclass(frozen=True)
class Kind:
    """A NAT, as RFC 4787 tells them apart."""

    routers: tuple = ()  # their rules, the outermost first
    one_port: bool = True  # the same outside for all whom a port of the inside sends to
    lets_in: bool = False  # others than those that were sent something


KINDS = {
    "open": Kind(lets_in=True),
    "full cone": Kind((KEEPS_PORTS + LETS_ALL_IN,), lets_in=True),
    "port-restricted": Kind((KEEPS_PORTS,)),
    "symmetric": Kind((DRAWS_PORTS,), one_port=False),
    "double": Kind((KEEPS_PORTS, KEEPS_PORTS)),
}


class Internet(Network):
    """A founder in the open, and machines behind routers. Homes have the same addresses, like those of real ones."""

    def __init__(self):
        super().__init__()
        self.outside = itertools.count(11)
        try:
            self.add("net")
            self.add_switch("net", "switch")
            self.on_switch("founder", FOUNDER)
            self.ip("founder", "addr", "add", f"{FOUNDER_TOO}/24", "dev", "outside")
            self.ip("founder", "addr", "add", f"{FOUNDER_V6}/64", "dev", "outside", "nodad")
        except BaseException:
            self.remove()
            raise

    def on_switch(self, machine, address):
        self.add(machine)
        self.plug(machine, "outside", "net", "switch", machine)
        if address:
            self.ip(machine, "addr", "add", f"{address}/24", "dev", "outside")

    def add_router(self, machine, behind, rules):
        """Behind another router, or none."""
        if behind is None:
            self.on_switch(machine, f"198.51.100.{next(self.outside)}")
        else:
            self.add(machine)
            self.plug(machine, "outside", behind, "inside", machine)
            self.ip(machine, "addr", "add", "100.64.0.2/24", "dev", "outside")
            self.ip(machine, "route", "add", "default", "via", "100.64.0.1")
        self.add_switch(machine, "inside")
        with self.inside(machine), open("/proc/sys/net/ipv4/ip_forward", "w", encoding="ascii") as forward:
            forward.write("1")
        self.run(machine, "nft", "-f", "-", text=ROUTER + rules)

    def add_home(self, name, kind, members):
        """Members behind routers of one kind."""
        behind = None
        for i, rules in enumerate(kind.routers):
            router = f"{name}r{i}"
            self.add_router(router, behind, rules)
            last = i + 1 == len(kind.routers)
            self.ip(router, "addr", "add", "192.168.0.1/24" if last else "100.64.0.1/24", "dev", "inside")
            behind = router
        for i, member in enumerate(members):
            if behind is None:
                self.on_switch(member, f"198.51.100.{next(self.outside)}")
            else:
                self.add(member)
                self.plug(member, "outside", behind, "inside", member)
                self.ip(member, "addr", "add", f"192.168.0.{i + 2}/24", "dev", "outside")
                self.ip(member, "route", "add", "default", "via", "192.168.0.1")

    def count_direct(self, members):
        """From now on, what comes to them from others than the founder."""
        for member in members:
            self.run(member, "nft", "-f", "-", text=COUNTS)

    def direct(self, member):
        """Datagrams that have come to the member from others than the founder."""
        listed = json.loads(self.run(member, "nft", "-j", "list", "counter", "inet", "counts", "direct"))
        (counter,) = [entry["counter"] for entry in listed["nftables"] if "counter" in entry]
        return counter["packets"]

    def socket(self, machine, address="", family=socket.AF_INET):
        with self.inside(machine):
            s = socket.socket(family, socket.SOCK_DGRAM)
        s.bind((address, 0))
        return s


COMES, DOES_NOT = 5.0, 0.2  # s until a datagram that should come has, and until one that should not would have


def seen(sender, receiver, address, patience=COMES):
    """Where a datagram comes from that is sent to the address; None if it does not come."""
    receiver.settimeout(patience)
    word = os.urandom(8)
    sender.sendto(word, address)
    while True:
        try:
            got, where = receiver.recvfrom(64)
        except TimeoutError:
            return None
        if got == word:
            return where


def why_no_internet():
    if shutil.which("nft") is None:
        return "there is no program 'nft' (Debian: nftables)"
    reason = why_no_namespaces()
    if reason:
        return reason
    network = Network()
    try:
        network.add("r")
        network.run("r", "nft", "-f", "-", text=ROUTER + DRAWS_PORTS + COUNTS)
    except subprocess.CalledProcessError as error:
        return f"NAT is not permitted: 'nft' says {error.stderr.strip()!r}"
    finally:
        network.remove()
    return ""
