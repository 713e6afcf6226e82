"""Sessions with a key: a peer with the key plays, one without it stays out; forged, replayed and reflected datagrams are dropped.

Usage: peer_sealed.py PADR_PEER [--datagrams N]: so many are forged, 20,000 if not said.
"""

import os
import random
import resource
import signal
import stat
import subprocess
import sys

from peers import PLAYING, PROGRAM, Case, main, run, unittest  # noqa: F401

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "conformance"))

from relay import Relay, loopback_socket  # noqa: E402

FORGED = int(sys.argv.pop(sys.argv.index("--datagrams") + 1)) if "--datagrams" in sys.argv else 20_000
if "--datagrams" in sys.argv:
    sys.argv.remove("--datagrams")
KEY, OTHER_KEY = "11" * 32, "22" * 32
SECONDS = 8


def with_key(key):
    return {**os.environ, "PADR_KEY": key}


class Keys(Case):
    def test_keygen(self):
        code, out, _ = run("keygen")
        self.assertEqual((code, len(bytes.fromhex(out.strip()))), (0, 32))
        self.assertNotEqual(run("keygen")[1], out)
        path = os.path.join(self.folder.name, "key")
        self.assertEqual(run("keygen", path)[:2], (0, ""))
        self.assertEqual(stat.S_IMODE(os.stat(path).st_mode), 0o600)
        code, _, err = run("keygen", path)
        self.assertEqual((code, path in err), (2, True), err)  # nobody's key is overwritten

    def test_a_key_that_cannot_be_written_leaves_no_file(self):
        path = os.path.join(self.folder.name, "key")
        def no_room():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        done = subprocess.run([PROGRAM, "keygen", path], capture_output=True, text=True, preexec_fn=no_room)
        self.assertEqual((done.returncode, os.path.exists(path)), (1, False), done.stderr)
        self.assertIn("File too large", done.stderr)

    def test_what_is_no_key_is_said(self):
        bad = self.file("bad", "11" * 31)
        for arguments, words in ((["--key-file", bad], ("--key-file", bad, "64 hexadecimal")),
                                 (["--key-file", bad + "x"], ("--key-file", "cannot read")),
                                 (["--seal", "encrypt"], ("--seal", "--key-file")),
                                 (["--keylog", bad], ("--keylog", "--key-file"))):  # fmt: skip
            code, _, err = run(*arguments)
            self.assertEqual(code, 2, err)
            for word in words:
                self.assertIn(word, err)
        good = self.file("good", KEY)
        link = os.path.join(self.folder.name, "link")
        os.symlink(os.path.join(self.folder.name, "elsewhere"), link)
        code, _, err = run("--key-file", good, "--keylog", link)
        self.assertEqual((code, "--keylog: cannot write" in err), (2, True), err)  # nobody leads us to another file
        code, _, err = run("--key-file", good, "--seal", "loudly")
        self.assertEqual((code, "auth or encrypt" in err), (2, True), err)

    def test_a_key_lets_a_peer_listen_to_the_network(self):
        peer = self.peer("--listen", "0.0.0.0:0", "--wait-peers", 1, "--duration", 0.5, env=with_key(KEY))
        self.assertEqual(peer.end(), 0, peer.text())


class Memory(Case):
    """A process with a key leaves no core dump, and no other process of its user looks into its memory."""

    def owners(self, *arguments, env=None):
        """Who owns the file that is the memory of a peer, its limit for core dumps and what its environment shows."""
        # Root owns it if it is protected. A group of its own tells that apart where root runs the test, too.
        group = (lambda: os.setgid(65534)) if os.geteuid() == 0 else None
        peer = self.peer("--wait-peers", 2, *arguments, env=env, preexec_fn=group)
        peer.port()
        process = f"/proc/{peer.process.pid}"
        owner = os.stat(f"{process}/mem")
        with open(f"{process}/limits", encoding="ascii") as file:
            (core,) = [line for line in file if line.startswith("Max core file size")]
        environment = b""
        if os.geteuid() == 0:
            with open(f"{process}/environ", "rb") as file:
                environment = file.read()
        return (owner.st_uid, owner.st_gid), core.split()[4:6], environment

    def test_it_is_protected_with_a_key(self):
        path = self.file("key", KEY + "\n")
        for arguments, env in ((["--key-file", path], None), ([], with_key(KEY))):
            owner, core, environment = self.owners(*arguments, env=env)
            self.assertEqual(owner, (0, 0))
            self.assertEqual(core, ["0", "0"])
            self.assertNotIn(KEY.encode(), environment)

    def test_without_a_key_it_is_as_usual(self):
        owner, _, _ = self.owners()
        self.assertEqual(owner, (os.geteuid(), 65534 if os.geteuid() == 0 else os.getegid()))

    def test_what_else_a_peer_does_works_all_the_same(self):
        """A capture, a trace, a summary and the log of keys, of a process that may not read its own /proc."""
        path, capture, trace, keys = self.file("key", KEY), *(os.path.join(self.folder.name, n) for n in ("pcap", "trace", "keys"))
        peer = self.peer("--wait-peers", 1, "--duration", 1, "--key-file", path, "--pcap", capture, "--trace", trace, "--keylog", keys)
        self.assertEqual(peer.end(), 0, peer.text())
        self.assertGreater(os.path.getsize(capture), 20)
        self.assertGreater(os.path.getsize(trace), 100)
        self.assertEqual(peer.summary()["seal"]["mode"], "auth")


class Sessions(Case):
    def test_a_key_log_that_cannot_be_written_ends_nobody(self):
        full = os.path.join(self.folder.name, "full")
        try:
            os.mknod(full, stat.S_IFCHR | 0o600, os.makedev(1, 7))  # as /dev/full, which keeps its permissions so
            os.close(os.open(full, os.O_WRONLY))
        except OSError as error:
            self.skipTest(f"no device can be made here: {error}")
        key = ["--key-file", self.file("key", KEY), "--duration", 2]
        founder = self.peer("--wait-peers", 2, *key, "--keylog", full)
        joiner = self.peer("--join", f"127.0.0.1:{founder.port()}", *key)
        self.assertEqual([founder.end(), joiner.end()], [1, 0], founder.text())
        self.assertIn("--keylog: cannot write '" + full + "': No space left on device: no more keys are written", founder.text())
        self.assertIn("ended: played to the end", founder.text())
        self.assertEqual(founder.summary()["exit_code"], 1)
        self.check_agreement([founder, joiner], 1)

    def test_peers_of_both_modes_play(self):
        path = self.file("key", KEY + "\n")
        own = [["--seal", "auth"], ["--seal", "encrypt"], []]
        peers = self.session(3, "--key-file", path, "--duration", 4, "--scenario", "arena", own=own)
        for p in peers:
            self.assertEqual(p.end(), 0, p.text())
        self.check_agreement(peers, 5)
        for p, mode in zip(peers, ("auth", "encrypt", "auth")):
            seal = p.summary()["seal"]
            self.assertEqual((seal["mode"], seal["moves"], seal["dropped"]["tag"]), (mode, 0, 0))
            self.assertEqual(seal["readable"] > 0, mode == "encrypt")
            warnings = [line for line in p.text().splitlines() if "sends readable datagrams" in line]
            self.assertEqual(len(warnings), 2 if mode == "encrypt" else 0, p.text())  # of each of the others, once

    def test_who_has_another_key_or_none_is_not_answered(self):
        founder = self.peer("--wait-peers", 2, "--join-timeout", 5, env=with_key(KEY))
        port = founder.port()
        for env in (with_key(OTHER_KEY), None):
            joiner = self.peer("--join", f"127.0.0.1:{port}", "--join-timeout", 1.5, env=env)
            self.assertEqual(joiner.end(), 1)
            self.assertIn("no answer", joiner.text())
        self.assertEqual(founder.end(), 1)
        self.assertIn("not made with this session's key", founder.text())
        seal = founder.summary()["seal"]
        self.assertEqual((seal["passed"], seal["handshakes"]), (0, 0))
        self.assertGreater(seal["dropped"]["tag"] + seal["dropped"]["unsealed"], 5)

    def test_a_newcomer_comes_in_and_keys_are_logged(self):
        log = self.file("keys", "what was there before\n" * 100)
        os.chmod(log, 0o644)
        founder = self.peer("--wait-peers", 1, "--slots", 3, "--duration", 6, "--keylog", log, env=with_key(KEY))
        founder.wait_for(PLAYING)
        joiner = self.peer("--join", f"127.0.0.1:{founder.port()}", "--duration", 3, env=with_key(KEY))
        self.assertEqual((joiner.end(), founder.end()), (0, 0))
        self.check_agreement([founder, joiner], 3)
        with open(log) as lines:
            words = [line.split() for line in lines]
        ours, theirs = (p.summary()["seal"]["public_key"] for p in (founder, joiner))
        self.assertEqual([w[:3] for w in words], 2 * [["padr-key", ours, theirs], ["padr-key", theirs, ours]])
        self.assertEqual(len({w[3] for w in words}), 4)  # the first keys and the next ones
        self.assertEqual([p.summary()["seal"]["rekeys"] for p in (founder, joiner)], [1, 1])
        self.assertEqual(stat.S_IMODE(os.stat(log).st_mode), 0o600)


class Forger:
    """Sees every datagram of a session, and adds to them: copies, as they were and damaged, from here and elsewhere, to whom
    they were for, to others, and back to who sent them; and datagrams of other sessions, of this key and of another."""

    def __init__(self, peers, wanted, seed, others):
        self.others = others
        self.random = random.Random(seed)
        self.genuine = [set() for _ in range(peers)]
        self.heap = []
        self.forged = 0
        self.wanted = wanted
        self.peers = peers
        self.elsewhere = loopback_socket()
        self.relay = None

    def __call__(self, sender, receiver, datagram):
        if datagram[2] & 12:  # not of the handshake
            self.genuine[receiver].add(datagram)
            self.heap.append((sender, receiver, datagram))
        if len(self.heap) > 300 and self.forged < self.wanted:
            for _ in range(200):
                self.forge()
        return []

    def forge(self):
        sender, receiver, datagram = self.random.choice(self.heap[-3000:-200])
        self.forged += 1
        sort = self.random.randrange(6)
        if sort == 0:
            at = self.random.randrange(len(datagram))
            datagram = datagram[:at] + bytes([datagram[at] ^ self.random.randrange(1, 256)]) + datagram[at + 1:]
        elif sort == 1:
            datagram = datagram[:6] + self.random.randbytes(len(datagram) - 6)
        elif sort == 2:
            sender, receiver = receiver, sender
        elif sort == 3:
            receiver = self.random.randrange(self.peers)
        elif sort == 4:
            datagram = self.random.choice(self.others)
        if receiver == sender:
            receiver = (receiver + 1) % self.peers
        from_here = self.random.random() < 0.5
        (self.relay.sockets[sender] if from_here else self.elsewhere).sendto(datagram, self.relay.addresses[receiver])


class Forgeries(Case):
    def overheard(self, key):
        """What two peers with a key say to one another."""
        heard = []
        founder = self.peer("--listen", "127.0.0.1:0", "--wait-peers", 2, "--duration", 1.5, env=with_key(key))
        relay = Relay(("127.0.0.1", founder.port()), 2, lambda _, __, datagram: heard.append(datagram) or [])
        try:
            joiner = self.peer("--join", f"127.0.0.1:{relay.port(0)}", "--duration", 1.5, env=with_key(key))
            relay.run_while(lambda: any(p.process.poll() is None for p in (founder, joiner)))
        finally:
            relay.close()
        self.assertEqual([founder.end(), joiner.end()], [0, 0])
        self.assertGreater(len(heard), 50)
        return heard

    def test_none_is_taken_in(self):
        seed = int(os.environ.get("PADR_SEED", "5"))
        print(f"seed {seed}, {FORGED} datagrams", file=sys.stderr)
        count = 3
        env = with_key(KEY)
        seconds = max(SECONDS, FORGED // 5000)
        founder = self.peer("--listen", "127.0.0.1:0", "--wait-peers", count, "--duration", seconds, env=env)
        peers = [founder]
        forger = Forger(count, FORGED, seed, self.overheard(KEY) + self.overheard(OTHER_KEY))
        relay = forger.relay = Relay(("127.0.0.1", founder.port()), count, forger, seed)
        try:
            for number in range(1, count):
                peers.append(self.peer("--join", f"127.0.0.1:{relay.port(0)}", "--duration", seconds, env=env))
                relay.run_while(lambda: len(relay.addresses) <= number and peers[-1].process.poll() is None)
            relay.run_while(lambda: any(p.process.poll() is None for p in peers))
        finally:
            relay.close()
            forger.elsewhere.close()
        for p in peers:
            self.assertEqual(p.end(), 0, p.text())
        self.check_agreement(peers, 5)
        came = 0
        for number, p in enumerate(peers):
            seal = p.summary()["seal"]
            print(f"peer {number}: {seal}", file=sys.stderr)
            self.assertLessEqual(seal["passed"], len(forger.genuine[number]))
            self.assertEqual((seal["moves"], p.summary()["others"]["removed"]), (0, 0))
            came += seal["dropped"]["tag"] + seal["dropped"]["replay"] + seal["dropped"]["stranger"]
        self.assertGreaterEqual(forger.forged, FORGED)
        print(f"forged {forger.forged}, refused {came}", file=sys.stderr)
        self.assertGreater(came, 0.8 * forger.forged)


main()
