#!/usr/bin/env python3
"""A crowd of real processes: they join one after another and cross borders, one is killed, and then all must agree on the regions.

Usage: peer_crowd.py PATH_TO_PADR_PEER [unittest arguments]
"""
import re

from peers import PATIENCE, Case, main, run, signal, time

NETEM = "delay 30ms 10ms loss 2%"
SIDE, REACH = 24.0, 6.0  # m, of a region, and beyond its border for guests
SETTLE = 8.0  # s: who is lost is out by then, and who stands has come in
# Over four regions in a row, each in a lane of its own: two who meet head on stop one another.
PLACES = [(4 + 10 * n, 4 + 2 * n) for n in range(9)]
LATE = [(20, 20), (50, 4)]


def inside_by(position, region):
    """How far a place is within a region, m; outside it is less than 0."""
    return min(min(p - c * SIDE, (c + 1) * SIDE - p) for p, c in zip(position, region))


def numbers(text):
    return tuple(int(part) for part in text.split(","))


class Crowd(Case):
    def walker(self, n, start, far, *arguments):
        """There and back, over a border or two, and then it stands."""
        path = [(0, start), (2, start), (8, far), (14, start), (1000, start)]
        file = self.file(f"{n}.csv", "t,x,y\n" + "".join(f"{t},{x},{y}\n" for t, (x, y) in path))
        return self.peer("--crowd", "--start", f"{start[0]},{start[1]}", "--input", f"path:{file}", "--netem", NETEM,
                         "--netem-seed", n + 1, *arguments)  # fmt: skip

    def test_who_is_near_is_known_and_believes_the_same(self):
        first = self.walker(0, PLACES[0], (30, 4))
        join = ["--join", f"127.0.0.1:{first.port()}"]
        peers = [first] + [self.walker(n, at, (at[0] + (26 if n < 5 else -26), at[1]), *join)
                           for n, at in enumerate(PLACES[1:], 1)]  # fmt: skip
        lost = self.walker(20, (36, 20), (36, 12), *join)
        for peer in [*peers, lost]:
            peer.wait_for("in the crowd: at home")
        time.sleep(4)
        # By another one than the first: anybody's address will do.
        late = [self.walker(30 + n, at, (at[0] + 5, at[1]), "--join", f"127.0.0.1:{peers[4].port()}")
                for n, at in enumerate(LATE)]  # fmt: skip
        for peer in late:
            peer.wait_for("in the crowd: at home")
        lost.process.kill()
        time.sleep(15 + SETTLE)
        everyone = peers + late
        for peer in everyone:
            peer.process.send_signal(signal.SIGTERM)
        self.assertEqual([peer.end(PATIENCE) for peer in everyone], [0] * len(everyone))
        summaries = [peer.summary() for peer in everyone]
        self.check_hashes(summaries, set().union(*(self.fallen_apart(peer) for peer in everyone)))
        self.check_neighbours(summaries)
        self.assertGreater(sum(s["handovers"] for s in summaries), len(everyone), "hardly anybody has crossed a border")

    def fallen_apart(self, peer):
        """Regions that two have founded, or that a machine which stood still for seconds has torn: two histories."""
        return set(re.findall(r"region (\S+): met \d+ peers? that goe?s? on without us", peer.text()))

    def check_hashes(self, summaries, apart):
        points = {}
        for s in summaries:
            self.assertEqual(sum(r["mismatches"] for r in s["regions"]), 0, s["regions"])
            for region, ticks in s["checkpoints"].items():
                if region in apart:
                    continue
                for tick, value in ticks.items():
                    points.setdefault((region, tick), []).append(value)
        shared = {point: values for point, values in points.items() if len(values) > 1}
        self.assertGreater(len(shared), 60)
        self.assertGreater(len({region for region, _ in shared}), 3)
        differing = sorted(point for point, values in shared.items() if len(set(values)) > 1)
        print(f"confirmed worlds held against each other: {len(shared)}, of {len({r for r, _ in shared})} regions; "
              f"differing: {len(differing)}; apart: {sorted(apart)}; merged {sum(s['merged'] for s in summaries)}")  # fmt: skip
        self.assertEqual(differing, [])

    def check_neighbours(self, summaries):
        """Who is in a region, or nearer to it than the reach, is a member there to all who are: on a busy machine all do
        not leave at once, and who leaves later may have taken the goodbye, which is under way for a tick at least."""
        left = {s["listen"]: s["last_tick"] for s in summaries}
        members = {s["listen"]: {numbers(r["region"]): set(r["others"]) for r in s["regions"]} for s in summaries}
        looked_at = 0
        for s in summaries:
            for region in {numbers(r["region"]) for other in summaries for r in other["regions"]}:
                if inside_by(s["position_m"], region) < 0.5 - REACH:
                    continue
                self.assertIn(region, members[s["listen"]], f"{s['listen']} at {s['position_m']}")
                for other, regions in members.items():
                    if other != s["listen"] and region in regions and left[other] <= s["last_tick"] + 1:
                        looked_at += 1
                        self.assertIn(s["listen"], regions[region], f"region {region}, to {other}")
        print(f"neighbours that had to be known, and were: {looked_at}")
        self.assertGreater(looked_at, 20)

    def test_another_crowd_is_told_of(self):
        first = self.peer("--crowd", "--seed", 1)
        port = first.port()
        first.wait_for("in the crowd: at home")
        code, _, err = run("--crowd", "--seed", 2, "--join", f"127.0.0.1:{port}")
        self.assertEqual(code, 1, err)
        self.assertIn("another crowd", err)

    def test_a_signal_while_a_neighbouring_region_lingers_spoils_nothing(self):
        def stands(x, *arguments):
            path = self.file(f"{x}.csv", f"t,x,y\n0,{x},12\n1000,{x},12\n")
            # So slow that the neighbour has not answered the goodbye before it is stopped.
            return self.peer("--crowd", "--start", f"{x},12", "--input", f"path:{path}", "--netem", "delay 500ms", *arguments)

        leaver = stands(20, "--duration", 8, "--status-interval", 0.2)
        neighbour = stands(36, "--join", f"127.0.0.1:{leaver.port()}")
        leaver.wait_for("2 regions, up to 1 other in one")
        leaver.wait_for("leaving 2 regions .* the time to play is over")
        neighbour.process.send_signal(signal.SIGSTOP)
        time.sleep(1.5)  # its own region has nobody else and is over; the other one lingers for 3 s
        leaver.process.send_signal(signal.SIGTERM)
        self.assertEqual(leaver.end(), 0, leaver.text())
        neighbour.process.send_signal(signal.SIGCONT)
        neighbour.process.send_signal(signal.SIGTERM)
        self.assertEqual(neighbour.end(), 0, neighbour.text())

    def test_nobody_there(self):
        code, _, err = run("--crowd", "--join", "127.0.0.1:9", "--join-timeout", 1)
        self.assertEqual(code, 1, err)
        self.assertIn("no answer from 127.0.0.1:9 within 1 s: nobody listens there", err)

    def test_a_session_is_no_crowd(self):
        place = f"127.0.0.1:{self.peer().port()}"
        code, _, err = run("--crowd", "--join", place, "--join-timeout", 1)
        self.assertEqual(code, 1, err)
        self.assertIn(f"no answer from {place} within 1 s; it may play in a session, not in a crowd", err)


if __name__ == "__main__":
    main()
