#!/usr/bin/env python3
"""End to end: real peers with --pcap and --trace, tcpdump beside them where that is permitted, and padr-capture.

Usage: capture_e2e.py PATH_TO_PADR_PEER PATH_TO_PADR_CAPTURE [unittest arguments]
"""

import collections
import json
import os
import shutil
import subprocess
import sys
import unittest
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "e2e"))
CAPTURE = sys.argv.pop(2)
SPEED = "--speed" in sys.argv  # sanitizers make it slow, and memory large
if SPEED:
    sys.argv.remove("--speed")

import pcap  # noqa: E402
from peers import PATIENCE, PLAYING, Case, main, signal, time  # noqa: E402

LINK = "delay 30ms 15ms loss 8% duplicate 6% corrupt 1%"


class Tcpdump:
    """tcpdump on the loopback device; `started` is false where that is not permitted."""

    def __init__(self, path):
        self.process = None
        if shutil.which("tcpdump") is None:
            return
        self.process = subprocess.Popen(
            # The buffer is divided into places of the snapshot length: with 256 KiB, the default, for some 30 packets.
            ["tcpdump", "-i", "lo", "-s", "4096", "-U", "--immediate-mode", "-B", "8192", "-w", path, "udp"],
            stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        for line in self.process.stderr:
            if "listening on" in line:
                return
        self.process.wait()
        self.process = None

    @property
    def started(self):
        return self.process is not None

    def stop(self, done):
        """Once `done`: a busy machine lets it lag behind, and stopping loses what it has not read yet."""
        deadline = time.monotonic() + PATIENCE
        while not done() and time.monotonic() < deadline:
            time.sleep(0.1)
        self.process.send_signal(signal.SIGINT)
        with self.process.stderr as log:
            said = log.read()
        self.process.wait()
        return said


def is_somebodys(datagram):
    return datagram[3] < 64 or datagram[3] == 255


def is_sealed(datagram):
    """By what it says itself: damage can make one seem so, or another's."""
    return is_somebodys(datagram) and 30 <= len(datagram) <= 1220 and datagram[2] in (0x94, 0x95, 0x96, 0x98, 0x99, 0x9A)


def is_claimed(datagram):
    """One whose first bytes were corrupted is taken for somebody else's."""
    if datagram[:2] != b"Pd" or len(datagram) < 6:
        return False
    good = len(datagram) >= 10 and zlib.crc32(datagram[:-4]) == int.from_bytes(datagram[-4:], "little")
    return good or is_sealed(datagram) or datagram[2] in (0x90, 0x91, 0x92) and is_somebodys(datagram)


def is_read(datagram):
    """One whose mode was corrupted is taken for an encrypted one, and nobody has a key for it."""
    return is_claimed(datagram) and not (is_sealed(datagram) and datagram[2] & 0x08)


def senders(keylog):
    """The ids of those who have a key in it, as sealed datagrams carry them."""
    with open(keylog, encoding="ascii") as f:
        return {bytes.fromhex(line.split()[1])[:4] for line in f}


def repeat(path, datagrams, size):
    pcap.write(path, datagrams)
    with open(path, "rb") as file:
        head, body = file.read(24), file.read()
    with open(path, "wb") as file:
        file.write(head)
        for _ in range(-(-size // len(datagrams))):
            file.write(body)


def cpu_and_memory(*command):
    """Seconds of processor time, and the most memory in KB."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss


class Captures(Case):
    def path(self, name):
        return os.path.join(self.folder.name, name)

    def own(self, i):
        return ["--pcap", self.path(f"{i}.pcapng"), "--trace", self.path(f"{i}.trace"), "--netem-seed", i + 1]

    def capture(self, *arguments, code=0):
        done = subprocess.run([CAPTURE, *map(str, arguments)], capture_output=True, text=True, timeout=60)
        allowed = [code] if isinstance(code, int) else code
        self.assertIn(done.returncode, allowed, f"{arguments}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def as_json(self, *arguments, code=0):
        return json.loads(self.capture(*arguments, "--json", "-", code=code))

    def check_rebuilt(self, *arguments, least):
        r = self.as_json("rebuild", *arguments)
        self.assertEqual(r["agreeing"], r["hashes"])
        self.assertGreaterEqual(r["hashes"], least)
        self.assertEqual([s["gap"] for s in r["stretches"]], [False] * len(r["stretches"]))
        return r

    def check_worlds(self, captures, traces, begin=0):
        """From tick `begin` on to the last tick that each peer has confirmed."""
        c = self.as_json("compare", *captures, *traces)
        self.assertTrue(c["agree"])
        for world in c["confirmed"]:
            self.assertEqual(world["alike"], world["compared"])
            self.assertLessEqual(world["not_rebuilt"], begin, world)
            self.assertGreater(world["compared"], 60)
        return c

    def test_what_is_sealed_is_checked_and_decrypted(self):
        key = self.file("key", "5a" * 32)
        own = [[*self.own(i), "--keylog", self.path(f"{i}.keys"), "--seal", ("auth", "encrypt")[i]] for i in range(2)]
        link = LINK.replace("corrupt 1%", "corrupt 5%")
        peers = self.session(2, "--netem", link, "--duration", 5, "--key-file", key, own=own)
        self.assertEqual([p.end() for p in peers], [0, 0])
        capture, traces = self.path("0.pcapng"), [self.path("0.trace"), self.path("1.trace")]
        keys = ["--keylog", self.path("0.keys")]
        c = self.as_json("compare", capture, *traces, *keys)
        self.assertTrue(c["agree"])
        self.check_rebuilt(capture, *keys, least=5)
        known, unknown = (self.as_json("summary", capture, *more)["sealed"] for more in (keys, []))
        # Only those whose sender's id the shim has damaged are nobody's.
        ids = senders(self.path("0.keys"))
        nobodys = [d[-1] for d in pcap.read(capture) if is_claimed(d[-1]) and is_sealed(d[-1]) and d[-1][6:10] not in ids]
        self.assertEqual(known["unchecked"] + known["encrypted"], len(nobodys))
        self.assertLess(len(nobodys), known["checked"] / 20)
        print(f"sealed: {known}, with a damaged id: {len(nobodys)}")
        self.assertGreaterEqual(known["handshakes"], 3)  # an Acceptance that is lost is not said again
        self.assertGreater(known["checked"], 50)
        self.assertGreater(known["wrong"], 0)  # the shim's corruption
        self.assertEqual(unknown["checked"], 0)
        self.assertGreater(min(unknown["unchecked"], unknown["encrypted"]), 20)
        blind = subprocess.run([CAPTURE, "rebuild", capture], capture_output=True, text=True, timeout=60)
        self.assertRegex(blind.stderr, "[0-9]+ datagrams are encrypted, and no --keylog has a key for them")
        keys[1] = self.file("none", "padr-key 12\n")
        self.assertEqual(self.capture("summary", capture, *keys, code=2), "")

    def test_carried_pairs_and_spectators(self):
        """Peers 1 and 2 do not reach each other, and peer 0, a meeting point, carries: any one's capture has it all."""
        key = ["--key-file", self.file("key", "5a" * 32), "--netem", "delay 20ms 5ms loss 2%"]
        own = [[*self.own(i), *key, "--keylog", self.path(f"{i}.keys")] for i in range(3)]
        peers = [self.peer("--listen", "127.0.0.1:0", "--meeting-point", "--wait-peers", 2, "--duration", 12, *own[0])]
        for i, other in ((1, 2), (2, 1)):
            join = ["--join", f"127.0.0.1:{peers[0].port()}", "--netem-to", f"{other}=loss 100%"]
            # The other one's last words are carried, too: whoever carries stays longer.
            peers.append(self.peer(*join, "--duration", 6, *own[i]))
            peers[i].wait_for(f"this is peer {i}|admitted at tick .* as peer {i}")
        self.assertEqual([p.end() for p in peers], [0, 0, 0])
        self.assertRegex(peers[1].text(), "peer 2 is reached through peer 0")
        traces = [self.path(f"{i}.trace") for i in range(3)]
        for i in range(3):
            capture, keys = self.path(f"{i}.pcapng"), ["--keylog", self.path(f"{i}.keys")]
            self.check_rebuilt(capture, *keys, least=6)
            self.assertTrue(self.as_json("compare", capture, *traces, *keys)["agree"])
        # The founder's keys are not those of what it carries, so what peer 2 tells peer 1 cannot be read.
        self.capture("rebuild", self.path("1.pcapng"), "--keylog", self.path("0.keys"), code=1)

    def test_who_gave_up_a_world_has_captured_it(self):
        peers = self.session(3, "--duration", 16, own=[self.own(i) for i in range(3)])
        for p in peers:
            p.wait_for(PLAYING)
        time.sleep(2)
        peers[2].process.send_signal(signal.SIGSTOP)
        time.sleep(5)
        peers[2].process.send_signal(signal.SIGCONT)
        peers[2].wait_for("life 2 begins")
        self.assertEqual([p.end() for p in peers], [0, 0, 0])
        traces = [self.path(f"{i}.trace") for i in range(3)] + [self.path("2.2.trace")]
        given_up = 0
        for i in range(3):
            c = self.as_json("compare", self.path(f"{i}.pcapng"), *traces)
            self.assertTrue(c["agree"], c)
            given_up += sum(w["given_up"] for w in c["confirmed"])
        print(f"{given_up} ticks of the captures were given up")

    def test_everybody_has_seen_the_same(self):
        tcpdump = Tcpdump(self.path("lo.pcap"))
        peers = self.session(2, "--netem", LINK, "--duration", 6, own=[self.own(0), self.own(1)])
        self.assertEqual([p.end() for p in peers], [0, 0])
        files = [self.path("0.pcapng"), self.path("1.pcapng")]
        traces = [self.path("0.trace"), self.path("1.trace")]
        seen = [collections.Counter(d[1:] for d in pcap.read(f)) for f in files]
        # Whoever ends first sees no more of what the other one sends.
        self.assertLessEqual((seen[0] - seen[1]).total() + (seen[1] - seen[0]).total(), 40)
        if tcpdump.started:
            ports = {end[1] for s in seen for d in s for end in d[:2]}

            def on_lo():
                datagrams = pcap.read(self.path("lo.pcap"))
                return collections.Counter(d[1:] for d in datagrams if {d[1][1], d[2][1]} <= ports)

            said = tcpdump.stop(lambda: on_lo().total() >= (seen[0] | seen[1]).total())
            self.assertIn("0 packets dropped by kernel", said)
            lo, peers_saw = on_lo(), seen[0] | seen[1]
            self.assertEqual((lo - peers_saw, peers_saw - lo), ({}, {}), "on lo alone, and at the peers alone")
            self.check_worlds([self.path("lo.pcap")], traces)
            print(f"tcpdump and both peers: the same {lo.total()} datagrams")
        else:
            print("tcpdump cannot capture here: only the peers' own captures are compared")
        for captures in ([files[0]], [files[1]], files):
            c = self.check_worlds(captures, traces)
            self.assertTrue(any(link["lost_before"] for link in c["links"]), "nothing was lost at 8 %")
        ours = [collections.Counter({d: n for d, n in s.items() if is_read(d[2])}) for s in seen]
        both = self.as_json("summary", *files)
        self.assertEqual(both["datagrams"], (ours[0] | ours[1]).total())
        self.assertEqual(both["seen_in_another_file"], (ours[0] & ours[1]).total())
        links = [link for s in both["sessions"] for link in s["links"]]
        self.assertEqual([s["delays_by"] for s in both["sessions"]], ["session clock"])
        for link in links:  # delay 30ms 15ms; on a loaded machine clocks differ by some ms, and datagrams are late
            self.assertGreater(link["delay_least_ms"], 5)
            self.assertTrue(20 < link["delay_mean_ms"] < 300, link)
        self.check_rebuilt(files[0], least=6)
        self.check_contradictions(files[0])
        self.check_middle(files[0], traces)
        self.check_begins_between_copies(files[0], traces)

    def test_killed_and_late(self):
        own = [self.own(i) for i in range(4)]
        peers = self.session(3, "--netem", "delay 20ms 5ms loss 3%", "--slots", 6, own=own[:3])
        peers[0].wait_for("peers? starts in")
        time.sleep(3)
        numbers = {p: 0 if p is peers[0] else int(p.wait_for(r"this is peer (\d+)")[1]) for p in peers}
        peers[2].process.kill()
        peers[1].wait_for(f"peer {numbers[peers[2]]} is lost: out from tick", 15)
        late = self.peer("--join", f"127.0.0.1:{peers[1].port()}", "--netem", "delay 20ms", "--duration", 2.5, *own[3])
        late.wait_for(PLAYING)
        came = time.time_ns()
        self.assertEqual(late.end(), 0)
        for p in peers[:2]:
            p.process.send_signal(signal.SIGINT)
        self.assertEqual([p.end() for p in peers[:2]], [0, 0])

        files = [self.path(f"{i}.pcapng") for i in range(4)]
        traces = [self.path(f"{i}.trace") for i in range(4)]
        # The one who was killed has written what happened until then, but for the last moment.
        self.assertGreater(len(pcap.read(files[2])), 50)
        for captures in (files, [files[0]]):
            self.check_worlds(captures, traces)
        # A capture of a peer that joined has nothing of the ticks before.
        joined = self.as_json("rebuild", files[1], "--scenario", "arena")["stretches"][0]["from"]
        self.check_worlds([files[1]], traces, begin=joined)
        r = self.check_rebuilt(*files, least=12)
        self.assertEqual([s["begins_with"] for s in r["stretches"]], ["session"])
        # Who came late has the world that it was given, and the start not.
        # What was lost when it ended came no more: then there is a gap at the end of its capture.
        r = self.as_json("rebuild", files[3], "--scenario", "arena", code=(0, 1))
        self.assertEqual(r["agreeing"], r["hashes"])
        self.assertGreaterEqual(r["hashes"], 3)
        self.assertEqual(len(r["stretches"]), 1)
        self.assertGreater(r["stretches"][0]["to"], r["stretches"][0]["from"] + 120)
        self.assertEqual(r["stretches"][-1]["begins_with"], "transfer")
        self.check_timeline(files, numbers[peers[2]])
        self.check_gap(files[0], numbers[peers[1]])  # of the founder, who gave the transfer
        # The middle of the session alone: from the transfer on.
        begin = self.path("middle.pcap")
        pcap.write(begin, [d for d in pcap.read(files[0]) if d[0] > came - 10**9])
        self.check_rebuilt(begin, least=3)

    @unittest.skipUnless(SPEED, "for optimised builds")
    def test_memory_is_constant_and_how_fast_it_is(self):
        peers = self.session(2, "--duration", 2, "--netem", "delay 20ms 10ms", own=[self.own(0), self.own(1)])
        self.assertEqual([p.end() for p in peers], [0, 0])
        recorded = pcap.read(self.path("0.pcapng"))
        sizes = (50_000, 500_000)
        cost = {}
        for size in sizes:
            path = self.path(f"{size}.pcap")
            repeat(path, recorded, size)
            cost[size] = cpu_and_memory(CAPTURE, "summary", path)
        rate = sizes[1] / cost[sizes[1]][0]
        print(f"summary: {rate / 1e6:.2f} million datagrams a second of one core, {cost[sizes[1]][1]} KB")
        self.assertLess(cost[sizes[1]][1] - cost[sizes[0]][1], 2048)
        if shutil.which("tshark"):
            theirs, memory = cpu_and_memory("tshark", "-r", self.path(f"{sizes[0]}.pcap"), "-q", "-z", "io,stat,0")
            print(f"tshark -q -z io,stat,0: {sizes[0] / theirs / 1e6:.3f} million, {memory} KB for a tenth of it")

    def check_timeline(self, files, killed):
        events = json.loads(self.capture("timeline", *files, "--json", "-"))["events"]
        names = collections.Counter(e["event"] for e in events)
        self.assertEqual(names["admission"], 3)
        self.assertEqual([e["other"] for e in events if e["event"] == "removal"], [killed])
        self.assertEqual(names["leave"], 3)
        self.assertGreater(names["claim"], 3)
        self.capture("timeline", *files, "--svg", self.path("t.svg"))
        with open(self.path("t.svg"), encoding="utf-8") as f:
            self.assertIn("</svg>", f.read())

    def check_contradictions(self, file):
        """What the packets tell no flag can change."""
        for flags, why in (
            (["--slots", 3], "--slots: the session's Welcome says [0-9]+, not 3"),
            (["--wait-peers", 5], "--wait-peers: the session's Welcome says 2, not 5"),
            (["--avatar-only"], "--avatar-only: the session was played with dynamic authority, its Join says"),
        ):
            refused = subprocess.run([CAPTURE, "rebuild", file, *map(str, flags)], capture_output=True, text=True, timeout=60)
            self.assertRegex(refused.stderr, why)
            self.assertEqual(refused.returncode, 2)

    def check_middle(self, file, traces):
        """Of a capture that begins later nothing can be rebuilt or compared, and that is no success."""
        middle = self.path("middle.pcap")
        datagrams = pcap.read(file)
        pcap.write(middle, [d for d in datagrams if d[0] > datagrams[-1][0] - 4 * 10**9])
        c = self.as_json("compare", middle, *traces, code=1)
        self.assertFalse(c["agree"])
        self.assertIn("had begun when the capture did", c["not_compared"])
        self.assertIn("THE WORLDS WERE NOT COMPARED", self.capture("compare", middle, *traces, code=1))
        self.assertEqual(self.capture("rebuild", middle, code=1), "")

    def check_begins_between_copies(self, file, traces):
        """Of a datagram that the network doubled a capture may have the second copy alone; traces have both."""
        datagrams = pcap.read(file)
        half = len(datagrams) // 2
        copies = [i for i in range(half, len(datagrams)) if datagrams[i][1:] in [d[1:] for d in datagrams[i + 1 :]]]
        self.assertTrue(copies, "nothing was doubled")
        for i in copies[:: max(1, len(copies) // 4)]:
            pcap.write(self.path("second.pcap"), datagrams[i + 1 :])
            for link in self.as_json("compare", self.path("second.pcap"), *traces, code=1)["links"]:
                self.assertEqual(link["contradictions"], [])

    def check_gap(self, file, of):
        """Without the datagrams that carry one certain update, the world ends there, and it is said why."""
        lines = self.capture("export", file, "--json").splitlines()
        records = [json.loads(line) for line in lines]
        datagrams = pcap.read(file)
        self.assertEqual(len(records), len(datagrams))
        index = 1  # from before anybody was given the world
        carries = [
            (of, index) in zip(r.get("padr.update.peer", []), r.get("padr.update.index", []))
            for r in records
        ]
        self.assertIn(True, carries)
        tick = next(t for r in records for p, i, t in zip(
            r.get("padr.update.peer", []), r.get("padr.update.index", []), r.get("padr.update.tick", [])) if (p, i) == (of, index))
        holed = self.path("holed.pcap")
        pcap.write(holed, [d for d, c in zip(datagrams, carries) if not c])
        r = self.as_json("rebuild", holed, code=1)
        self.assertTrue(r["stretches"][0]["gap"])
        self.assertIn(f"update {index} of peer {of} is not in the capture", r["stretches"][0]["why"])
        self.assertLessEqual(r["stretches"][0]["to"], tick)
        self.assertEqual(r["agreeing"], r["hashes"])
        # A transfer begins another stretch behind the gap.
        self.assertEqual(r["stretches"][-1]["begins_with"], "transfer")


if __name__ == "__main__":
    main()
