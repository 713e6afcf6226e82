"""A session of real peers over UDP on the loopback, captured by tcpdump, in which everything happens that peers tell of.

Somebody is refused, somebody leaves before the start, the others gather and play over a bad network; one is killed, one comes
late, one leaves, and the rest end.
"""
import signal
import socket
import struct
import subprocess
import time

from peers import PATIENCE, PLAYING, Peer

NETEM = "delay 20ms 10ms loss 8% duplicate 1% corrupt 1%"


class NotPermitted(Exception):
    """This user may not capture."""


class Capture:
    """tcpdump on the loopback, of datagrams between these ports."""

    def __init__(self, path, ports):
        wanted = " or ".join(f"port {port}" for port in ports)
        self.path = path
        with open(path, "wb") as file:
            self.process = subprocess.Popen(
                ["tcpdump", "-i", "lo", "-s", "65535", "-B", "32768", "-U", "-w", "-", f"ip and udp and ({wanted})"],
                stdout=file, stderr=subprocess.PIPE, text=True)  # fmt: skip
        said = []
        for line in self.process.stderr:
            said.append(line)
            if "listening on" in line:
                return
        self.process.wait()
        raise NotPermitted("".join(said).strip())

    def frames(self):
        """How many there are by now."""
        count, at = 0, 24
        with open(self.path, "rb") as file:
            while True:
                file.seek(at)
                header = file.read(16)
                if len(header) < 16:
                    return count
                at += 16 + struct.unpack_from("<I", header, 8)[0]
                count += 1

    def stop(self):
        """Gives how many packets tcpdump could not keep up with."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        said = self.process.stderr.read()
        self.process.wait()
        return int(next(line for line in said.splitlines() if "dropped by kernel" in line).split()[0])


def free_ports(count):
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Play:
    def __init__(self, ports, members, chatty, flags):
        self.ports, self.members, self.chatty, self.flags = iter(ports), members, chatty, flags
        self.peers, self.port_of = [], {}

    def peer(self, *arguments, flags=None):
        port = next(self.ports)
        peer = Peer("--listen", f"127.0.0.1:{port}", *(self.flags if flags is None else flags), *arguments)
        self.peers.append(peer)
        self.port_of[peer] = port
        peer.wait_for(r"listening on")
        return peer

    def join(self, by, *arguments, **more):
        return self.peer("--join", f"127.0.0.1:{self.port_of[by]}", *arguments, **more)

    def before_the_start(self):
        """A founder that waits; one is refused, one comes and goes."""
        founder = self.peer("--wait-peers", 3, flags=[])
        refused = self.join(founder, "--seed", 99, flags=[])
        assert refused.end() == 1, refused.text()
        guest = self.join(founder, flags=[])
        founder.wait_for("peer 1 at .* joins")
        for each in (guest, founder):
            each.process.send_signal(signal.SIGINT)
            each.end()

    def gather(self):
        """The members, some of which tell everything at every tick; the last one asks one that is not the founder."""
        founder = self.peer("--wait-peers", self.members)
        members = [founder] + [self.join(founder, "--technique", "everything") for _ in range(self.chatty)]
        members += [self.join(founder) for _ in range(self.members - 2 - self.chatty)]
        founder.wait_for("peer 1 at .* joins")
        # Of what the victim sends little gets to the founder: others have to hand it over when the victim is gone.
        bad = f"127.0.0.1:{self.port_of[founder]}=delay 20ms loss 60%"
        members.append(self.join(members[1], "--netem-to", bad, "--threshold", "0.05:0.02", "--input", "wander:4"))
        for each in members:
            each.wait_for(PLAYING)
        return members

    def run(self, enough):
        """Waits until enough() after each of the things that happen during play; all that is left leaves properly."""
        self.before_the_start()
        members = self.gather()
        founder, victim = members[0], members[-1]
        enough(1)
        number = victim.wait_for(r"this is peer (\d+)")[1]
        victim.process.kill()
        founder.wait_for(f"peer {number} is lost: out from tick")
        late = self.join(members[1])
        late.wait_for(PLAYING)
        enough(2)
        late.process.send_signal(signal.SIGINT)
        assert late.end() == 0, late.text()
        enough(3)
        for each in members[:-1]:
            each.process.send_signal(signal.SIGINT)
        for each in members[:-1]:
            assert each.end() == 0, each.text()

    def stop(self):
        for each in self.peers:
            each.stop()


def record(path, wanted, members, chatty):
    """Plays and captures about so many datagrams; gives how many frames tcpdump has lost."""
    ports = free_ports(members + 4)
    capture = Capture(path, ports)
    play = Play(ports, members, chatty, ["--netem", NETEM, "--status-interval", "0"])

    def enough(third):
        deadline = time.monotonic() + PATIENCE + wanted / 500
        while capture.frames() < wanted * third / 3:
            assert time.monotonic() < deadline, f"only {capture.frames()} datagrams"
            time.sleep(0.1)

    try:
        play.run(enough)
    except BaseException:
        for each in play.peers:
            print(f"--- {each.arguments}\n{each.text()}")
        raise
    finally:
        play.stop()
        lost = capture.stop()
    return lost
