#!/usr/bin/env python3
"""End to end behind NATs: every pair of kinds plays, by the way that it should.

Each session has an Internet of its own, of network namespaces and nftables: a founder in the open, whom all reach, and two
members, each of whom is behind a NAT. Before they play, UDP datagrams of the test's own show that each NAT is of its kind;
afterwards the kernel's counters say what came from one of the two to the other one. Skipped where that is not permitted.

Usage: peer_nats.py PATH_TO_PADR_PEER [--seconds N] [--at-once N] [--only WORD] [--netem SPEC] [unittest arguments]
  --seconds N   so long each session plays, except the longest, 60 s; 12 if not said
  --at-once N   so many sessions at once, besides the longest; 6 if not said
  --only WORD   only sessions in whose name the word is
  --netem SPEC  of what all peers send; none if not said
"""

import collections
import dataclasses
import itertools
import os
import re
import signal
import socket
import sys
from collections.abc import Callable

from hosts import main_unless
from internet import COMES, DOES_NOT, FOUNDER, FOUNDER_TOO, FOUNDER_V6, KINDS, Internet, seen, why_no_internet
from peers import PLAYING, Case


def argument(name, standard):
    if name not in sys.argv:
        return standard
    at = sys.argv.index(name)
    value = sys.argv[at + 1]
    del sys.argv[at : at + 2]
    return type(standard)(value)


SECONDS = argument("--seconds", 12)
AT_ONCE = argument("--at-once", 6)
ONLY = argument("--only", "")
NETEM = argument("--netem", "")
LATER = "later"
LATER_IS, LATER_PLAYS = 12, 25  # s after the beginning of play, and s of play
HARDEST = ("symmetric", "symmetric")
LONG = 60  # s
STAYS = 10  # s that the members play longer which a newcomer comes to
PLAYS_WITHIN = 3000  # ms from the start of the process
PATIENCE = 30  # s that a session may end late
KEY = "11" * 32
HEAD = """pair                                  seal         s  plays after ms  confirms after  came directly  carried  lost
                                                                a      b       a      b      a      b"""
ROW = "{:37} {:8} {:5} {:8} {:6} {:7} {:6} {:6} {:6} {:8} {:5}"


def is_direct(a, b):
    """Whether two that a third one introduces reach each other: one lets everybody in, or both are known by the port at which
    the other one will see them."""
    return a.lets_in or b.lets_in or (a.one_port and b.one_port)


def needs_key(a, b):
    """In a session with a key, a member that comes from another port than was said is known by its key."""
    return not (a.one_port and b.one_port)


@dataclasses.dataclass(frozen=True)
class Plan:
    """One session of a founder and members a and b."""

    name: str
    seal: str  # "": no key
    direct: bool | str  # a and b reach each other; LATER: by the addresses that they have themselves
    seconds: int
    prepare: Callable  # given the Trial: what stands between the members
    founder: str = "0.0.0.0:0"  # where it listens
    members: tuple = (("0.0.0.0:0", FOUNDER),) * 2  # where each listens and joins
    founds: tuple = ("--wait-peers", 3)  # flags of the founder


class Trial:
    """A plan that is carried out."""

    def __init__(self, case, plan):
        self.case, self.plan = case, plan
        self.peers = []
        self.internet = Internet()
        try:
            plan.prepare(self)
            self.internet.count_direct("ab")
            self.start()
        except BaseException:
            self.remove()
            raise

    def behind(self, *kinds):
        """Each member has a NAT of its own."""
        for member, kind in zip("ab", kinds):
            self.internet.add_home(f"{member}h", kind, [member])
            self.prove_kind(member, kind)

    def behind_one(self, kind):
        self.internet.add_home("h", kind, "ab")
        for member in "ab":
            self.prove_kind(member, kind)
        self.prove_no_hairpin("a", "b")

    def of_two_families(self, kind):
        """a has only IPv6, b only IPv4."""
        self.internet.on_switch("a", None)
        self.add_v6("a")
        self.internet.add_home("bh", kind, "b")
        self.prove_kind("b", kind)
        for member, family, elsewhere in (("a", socket.AF_INET, FOUNDER), ("b", socket.AF_INET6, FOUNDER_V6)):
            with self.internet.socket(member, family=family) as s, self.case.assertRaisesRegex(OSError, "unreachable"):
                s.sendto(b"", (elsewhere, 9))

    def of_both_families(self, kind):
        """a has both, b only IPv4."""
        self.behind(KINDS["open"], kind)
        self.add_v6("a")

    def add_v6(self, member):
        self.internet.ip(member, "addr", "add", "2001:db8::a/64", "dev", "outside", "nodad")

    def prove_kind(self, member, kind):
        """The member's NAT is what it is taken for."""
        case, internet = self.case, self.internet
        with (
            internet.socket(member) as inside,
            internet.socket("founder", FOUNDER) as first,
            internet.socket("founder", FOUNDER) as other_port,
            internet.socket("founder", FOUNDER_TOO) as other_address,
        ):
            there = seen(inside, first, first.getsockname())
            case.assertIsNotNone(there, f"{member} reaches the founder")
            case.assertIsNotNone(seen(first, inside, there), f"{member} gets an answer")
            for other in (other_port, other_address):
                let_in = seen(other, inside, there, COMES if kind.lets_in else DOES_NOT) is not None
                case.assertEqual(let_in, kind.lets_in, f"{member} gets what {other.getsockname()} sends")
            ports = {seen(inside, s, s.getsockname())[1] for s in (first, other_port, other_address)}
            case.assertEqual(ports == {inside.getsockname()[1]}, kind.one_port, f"{member} has one port, its own")

    def prove_no_hairpin(self, one, other):
        """Two behind one router reach each other there, and not by their address outside."""
        internet = self.internet
        with internet.socket(one) as a, internet.socket(other) as b, internet.socket("founder", FOUNDER) as first:
            a_there, b_there = (seen(s, first, first.getsockname()) for s in (a, b))
            self.case.assertEqual(a_there[0], b_there[0])
            for _ in range(2):  # the second time, both have sent something
                self.case.assertIsNone(seen(a, b, b_there, DOES_NOT))
                self.case.assertIsNone(seen(b, a, a_there, DOES_NOT))
            self.case.assertIsNotNone(seen(a, b, ("192.168.0.3", b.getsockname()[1])))

    def peer(self, machine, *arguments, longer=0):
        plan = self.plan
        env = {**os.environ, "PADR_KEY": KEY} if plan.seal else None
        options = ["--duration", plan.seconds + longer, "--status-interval", 0.2, "--netem", NETEM]
        options += ["--seal", plan.seal] if plan.seal else ["--insecure"]

        self.peers.append(self.case.peer(*arguments, *options, env=env, preexec_fn=self.internet.enter(machine)))
        return self.peers[-1]

    def start(self):
        port = self.peer("founder", *self.plan.founds, "--listen", self.plan.founder).port()
        for machine, (listen, founder) in zip("ab", self.plan.members):
            self.peer(machine, "--listen", listen, "--join", f"{founder}:{port}")

    def finish(self):
        try:
            self.check()
        except AssertionError as error:
            logs = [f"--- log of {p.arguments}, exit {p.process.poll()}\n{p.text()}" for p in self.peers]
            raise AssertionError("\n".join([str(error), *logs])) from None
        finally:
            self.remove()

    def remove(self):
        for p in self.peers:
            p.stop()
            self.case.peers.remove(p)
        self.internet.remove()

    def check(self):
        case, plan = self.case, self.plan
        for p in self.peers:
            case.assertEqual(p.end(patience=plan.seconds + PATIENCE), 0)
        summaries = [p.summary() for p in self.peers]
        plays = [round(s["join_ms"]) for s in summaries[1:]]
        confirms = [round(confirmed_after(p, s["first_tick"])) for p, s in zip(self.peers[1:], summaries[1:])]
        came = [self.internet.direct(m) for m in "ab"]
        carried = summaries[0]["seal"]["carried"] if plan.seal else 0
        removed = sum(s["others"]["removed"] for s in summaries)
        what = (plan.name, plan.seal or "no key", plan.seconds)
        print(ROW.format(*what, *plays, *confirms, *came, carried, removed), flush=True)
        self.check_nobody_is_lost(summaries)
        case.assertLessEqual(max(plays + confirms), PLAYS_WITHIN)
        case.check_agreement(self.peers, least_common=plan.seconds - 3)
        self.check_way(came, [s["session"]["datagrams"]["foreign"] for s in summaries[1:]], carried)

    def check_nobody_is_lost(self, summaries):
        for p, s in zip(self.peers, summaries):
            self.case.assertNotRegex(p.text(), "silent for|is lost|joining anew")
            self.case.assertEqual((len(s["lives"]), s["others"]["removed"]), (1, 0))

    def check_carried(self, came, carried):
        self.case.assertEqual(came, [0, 0])
        self.case.assertGreaterEqual(carried, 2 * self.plan.seconds)

    def check_way(self, came, foreign, carried):
        case, plan = self.case, self.plan
        if plan.direct == LATER:
            case.assertGreaterEqual(min(came), plan.seconds - LATER_IS)
            for p in self.peers[1:]:
                lines = p.text().splitlines()
                begin = next(time_of(line) for line in lines if re.search(PLAYING, line))
                again = [time_of(line) - begin for line in lines if "directly again" in line]
                case.assertTrue(again or not any("is reached through" in line for line in lines), "directly again")
                case.assertLess(max(again, default=0), LATER_IS)
                case.assertNotIn("carried:", [line for line in lines if "status:" in line][-1])
            return
        if plan.direct:
            # A member sends something to each other one at least once a second.
            case.assertGreaterEqual(min(came), plan.seconds)
            # Without a key it does not know who sends from another address than was said.
            case.assertLess(max(foreign), plan.seconds)
            case.assertEqual(carried, 0)
            for p in self.peers:
                case.assertNotRegex(p.text(), "is reached through|carried:")
            return
        self.check_carried(came, carried)
        for p in self.peers[1:]:
            case.assertRegex(p.text(), "peer [12] is reached through peer 0")
            case.assertRegex(p.text(), "status: .* carried: [12] by 0")
            case.assertNotIn("directly again", p.text())


class HiddenCoordinator(Trial):
    """The founder leaves, and a, behind its NAT, is the coordinator. Then b joins by a member in the open."""

    def start(self):
        (listen_a, founder), (listen_b, asked) = self.plan.members
        port = self.peer("founder", "--wait-peers", 3, "--listen", self.plan.founder, longer=STAYS).port()
        self.peer("a", "--listen", listen_a, "--join", f"{founder}:{port}", longer=STAYS).wait_for("admitted at tick")
        member = self.peer("founder", "--listen", self.plan.founder, "--join", f"{founder}:{port}", longer=STAYS)
        for p in self.peers:
            p.wait_for(PLAYING)
        leaver = self.peers.pop(0)
        leaver.process.send_signal(signal.SIGINT)
        self.case.assertEqual(leaver.end(), 0)
        leaver.stop()
        self.case.peers.remove(leaver)
        self.peer("b", "--listen", listen_b, "--join", f"{asked}:{member.port()}")

    def check(self):
        case, plan = self.case, self.plan
        coordinator, member, newcomer = self.peers
        for p in self.peers:
            case.assertEqual(p.end(patience=plan.seconds + STAYS + PATIENCE), 0)
        summaries = [p.summary() for p in self.peers]
        plays = round(summaries[2]["join_ms"])
        confirms = round(confirmed_after(newcomer, summaries[2]["first_tick"]))
        came = [self.internet.direct(m) for m in "ab"]
        carried = summaries[1]["seal"]["carried"] if plan.seal else 0
        what = (plan.name, plan.seal or "no key", plan.seconds)
        print(ROW.format(*what, "", plays, "", confirms, *came, carried, ""), flush=True)
        case.assertRegex(newcomer.text(), "passes us on to")
        self.check_nobody_is_lost(summaries)
        case.assertLessEqual(max(plays, confirms), PLAYS_WITHIN)
        case.check_agreement(self.peers, least_common=plan.seconds - 3)
        if plan.direct:
            case.assertGreaterEqual(min(came), plan.seconds)
            case.assertEqual(carried, 0)
            return
        self.check_carried(came, carried)


def time_of(line):
    """s since midnight."""
    hours, minutes, seconds = re.match(r"(\d+):(\d+):([\d.]+)", line).groups()
    return 3600 * int(hours) + 60 * int(minutes) + float(seconds)


def confirmed_after(peer, tick):
    """ms from the peer's first line to the status line by which the tick is confirmed: all must have been heard for that."""

    lines = peer.text().splitlines()
    for line in lines:
        found = re.search(r"status: .* confirmed .*@(\d+)", line)
        if found and int(found[1]) >= tick:
            return (time_of(line) - time_of(lines[0])) % 86400 * 1000
    raise AssertionError(f"{peer.arguments} has never confirmed tick {tick}")


def plans():
    """The longest first."""
    seals = itertools.cycle(("auth", "encrypt"))
    pairs = sorted(itertools.combinations_with_replacement(KINDS, 2), key=lambda pair: pair != HARDEST)
    for names in pairs:
        a, b = kinds = [KINDS[name] for name in names]
        seconds = max(SECONDS, LONG) if names == HARDEST else SECONDS
        way = is_direct(a, b)
        for seal in (next(seals), "") if way and not needs_key(a, b) else (next(seals),):
            yield Plan(" - ".join(names), seal, way, seconds, lambda trial, kinds=kinds: trial.behind(*kinds))
    restricted, in_the_open = KINDS["port-restricted"], KINDS["open"]
    yield Plan("two behind one, no hairpin", "auth", LATER, max(SECONDS, LATER_PLAYS), lambda trial: trial.behind_one(restricted))
    symmetric = [KINDS[name] for name in HARDEST]
    meeting_point = ("--meeting-point", "--wait-peers", 2)
    yield Plan("symmetric, meeting point", "auth", False, SECONDS, lambda trial: trial.behind(*symmetric), founds=meeting_point)
    v4, by_v4, by_v6 = ("0.0.0.0:0", FOUNDER), ("[::]:0", FOUNDER), ("[::]:0", f"[{FOUNDER_V6}]")
    for name, seal, way, prepare, members in (
        ("IPv6 - open IPv4", "encrypt", False, lambda trial: trial.of_two_families(in_the_open), (by_v6, v4)),
        ("both, by IPv6 - open IPv4", "auth", True, lambda trial: trial.of_both_families(in_the_open), (by_v6, v4)),
        ("both, by IPv6 - restricted IPv4", "auth", LATER, lambda trial: trial.of_both_families(restricted), (by_v6, v4)),
        ("both, by IPv4 - restricted IPv4", "encrypt", True, lambda trial: trial.of_both_families(restricted), (by_v4, v4)),
        ("both, by IPv4 - restricted IPv4", "", True, lambda trial: trial.of_both_families(restricted), (by_v4, v4)),
    ):
        seconds = max(SECONDS, LATER_PLAYS) if way == LATER else SECONDS
        yield Plan(name, seal, way, seconds, prepare, "[::]:0" if by_v6 in members else "0.0.0.0:0", members)


def plans_of_hidden_coordinators():
    v4, by_v6 = ("0.0.0.0:0", FOUNDER), ("[::]:0", f"[{FOUNDER_V6}]")
    for a, b, seal in (
        ("port-restricted", "open", ""),
        ("port-restricted", "open", "auth"),
        ("port-restricted", "port-restricted", ""),
        ("double", "port-restricted", "encrypt"),
        ("open", "open", "auth"),
        ("symmetric", "open", "encrypt"),
        ("symmetric", "port-restricted", "auth"),
        ("port-restricted", "symmetric", "encrypt"),
        ("symmetric", "symmetric", "auth"),
    ):
        kinds = KINDS[a], KINDS[b]
        name = f"{b} asks, {a} lets in"
        yield Plan(name, seal, is_direct(*kinds), SECONDS, lambda trial, kinds=kinds: trial.behind(*kinds))
    restricted = KINDS["port-restricted"]
    name = "restricted IPv4 asks, IPv6 lets in"
    yield Plan(name, "auth", False, SECONDS, lambda trial: trial.of_two_families(restricted), "[::]:0", (by_v6, v4))


class Nats(Case):
    def test_all_pairs_play(self):
        self.play_all(plans(), Trial)

    def test_a_newcomer_gets_through_to_a_hidden_coordinator(self):
        self.play_all(plans_of_hidden_coordinators(), HiddenCoordinator)

    def play_all(self, all_plans, trial):
        running = collections.deque()

        def finish_oldest():
            trial = running.popleft()
            with self.subTest(trial.plan.name, seal=trial.plan.seal):
                trial.finish()

        print(HEAD, flush=True)
        try:
            for plan in all_plans:
                if ONLY not in f"{plan.name}, {plan.seal or 'no key'}":
                    continue
                if len(running) > AT_ONCE:
                    running.rotate(-1 if running[0].plan.seconds > SECONDS else 0)  # the longest ends last
                    finish_oldest()
                with self.subTest(plan.name, seal=plan.seal):
                    running.append(trial(self, plan))
            while running:
                finish_oldest()
        finally:
            for trial in running:
                trial.remove()


if __name__ == "__main__":
    main_unless(why_no_internet())
