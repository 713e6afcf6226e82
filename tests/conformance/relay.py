"""A relay for every datagram of a session: it has one socket for each peer, and the other peers send to that socket.

A peer knows the others only by the addresses their datagrams come from, and the founder tells those on. So the relay takes a
datagram that peer Y sent to the socket of X, and sends it on to X from the socket of Y. The relay is the bad network as well:
it sees every datagram before anything happens to it.
"""
import heapq
import random
import select
import socket
import time

LOSS, DUPLICATE, DELAY, JITTER = 0.10, 0.02, 0.060, 0.030
FOUNDER = 0


def loopback_socket():
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    made.bind(("127.0.0.1", 0))
    return made


class Relay:
    """Peers are numbered in the order in which they turn up; the founder, whose address must be told, is 0."""

    def __init__(self, founder, peers, on_datagram, seed=1):
        """on_datagram(sender, receiver, bytes) may give datagrams to deliver besides."""
        self.sockets = [loopback_socket() for _ in range(peers)]
        self.addresses = [founder]
        self.on_datagram = on_datagram
        self.random = random.Random(seed)
        self.waiting = []
        self.count = 0

    def port(self, peer):
        return self.sockets[peer].getsockname()[1]

    def run_while(self, alive):
        while alive():
            due = self.waiting[0][0] - time.monotonic() if self.waiting else 0.1
            readable, _, _ = select.select(self.sockets, [], [], min(max(due, 0), 0.1))
            for ready in readable:
                self.receive(self.sockets.index(ready))
            self.deliver()

    def close(self):
        for each in self.sockets:
            each.close()

    def receive(self, receiver):
        try:
            datagram, address = self.sockets[receiver].recvfrom(65536)
        except ConnectionError:  # of an earlier datagram to a peer that has ended
            return
        if address not in self.addresses:
            self.addresses.append(address)
        sender = self.addresses.index(address)
        more = self.on_datagram(sender, receiver, datagram)
        if self.random.random() >= LOSS:
            self.delay(sender, receiver, datagram)
        if self.random.random() < DUPLICATE:
            self.delay(sender, receiver, datagram)
        for datagram in more:
            self.delay(sender, receiver, datagram)

    def delay(self, sender, receiver, datagram):
        due = time.monotonic() + DELAY + self.random.uniform(-JITTER, JITTER)
        self.count += 1
        heapq.heappush(self.waiting, (due, self.count, sender, receiver, datagram))

    def deliver(self):
        while self.waiting and self.waiting[0][0] <= time.monotonic():
            _, _, sender, receiver, datagram = heapq.heappop(self.waiting)
            self.sockets[sender].sendto(datagram, self.addresses[receiver])
