"""padr-peer and a monitor: what it tells, that it obeys, and that nobody else can make it."""

import contextlib
import os
import threading

from monitor_wire import PREAMBLE, Monitor, fields, number, put, real
from peers import PATIENCE, PLAYING, Case, main, run, signal, socket, time, unittest

RELEASE, POINT, DIRECTION = 0, 1, 2
QUIET = ["--status-interval", "0"]


class Relay:
    """Passes datagrams on between one client and a port, so that the port knows the client by an address of ours."""

    def __init__(self, port):
        self.inner, self.outer = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        for s in (self.inner, self.outer):
            s.bind(("127.0.0.1", 0))
            s.settimeout(0.05)
        self.client, self.target = None, ("127.0.0.1", port)
        self.ending = False
        self.threads = [threading.Thread(target=work) for work in (self.go, self.come)]
        for t in self.threads:
            t.start()

    def port(self):
        return self.inner.getsockname()[1]

    def go(self):
        while not self.ending:
            with contextlib.suppress(TimeoutError):
                datagram, self.client = self.inner.recvfrom(2000)
                self.outer.sendto(datagram, self.target)

    def come(self):
        while not self.ending:
            with contextlib.suppress(TimeoutError):
                datagram, _ = self.outer.recvfrom(2000)
                self.inner.sendto(datagram, self.client)

    def close(self):
        self.ending = True
        for t in self.threads:
            t.join()
        self.inner.close()
        self.outer.close()


class MonitorCase(Case):
    def setUp(self):
        super().setUp()
        self.monitors = []

    def tearDown(self):
        for m in self.monitors:
            m.close()
        super().tearDown()

    def monitor(self, port=0):
        m = Monitor(port)
        self.monitors.append(m)
        return m

    def told(self, count, *arguments, own=None):
        """A monitor and a session whose peers tell it."""
        m = self.monitor()
        peers = self.session(count, *QUIET, "--monitor", f"127.0.0.1:{m.port()}", *arguments, own=own)
        return m, peers


class Telling(MonitorCase):
    def test_frames_come_at_the_rate_and_of_the_same_ticks(self):
        m, _ = self.told(2, "--duration", 30)
        a, b = m.slot(0, 100), m.slot(1, 100)
        for t in (a, b):
            ticks = [f.tick for f in t.frames]
            self.assertTrue(all(tick % 3 == 0 for tick in ticks), "20 a second: every third tick")
            self.assertGreater(len(ticks), 0.8 * (ticks[-1] - ticks[0]) / 3, "some got lost on this machine")
            self.assertEqual(t.frames[-1].details, 3)
            # A frame may take several datagrams; the newest may still be on the way.
            m.wait_until(lambda: len(t.frames[-1].shown) == t.frames[-1].total)  # noqa: B023
        common = m.wait_until(lambda: sorted(set(a.agreed) & set(b.agreed))[20:])
        self.assertTrue(all(a.agreed[t] == b.agreed[t] for t in common), "confirmed worlds are the same")

    def test_rate_and_detail_are_adjustable(self):
        m, _ = self.told(2, "--duration", 30, own=[["--monitor-rate", 60, "--monitor-detail", "shown"],
                                                   ["--monitor-rate", 1, "--monitor-detail", "live"]])  # fmt: skip
        fast, slow = m.slot(0, 120), m.slot(1, 2)
        self.assertEqual(fast.frames[-1].details, 1)
        self.assertEqual(slow.frames[-1].details, 2)
        self.assertEqual(slow.frames[1].tick - slow.frames[0].tick, 60)
        self.assertGreater(len(fast.frames), 20 * len(slow.frames))
        self.assertEqual(fast.agreed, {})

    def test_hello_says_all_there_is_to_know(self):
        m, peers = self.told(2, "--duration", 20, "--scenario", "clutter", "--seed", 5, "--netem", "delay 20ms")
        t = m.slot(1)
        text = m.wait_until(lambda: sum(map(len, t.pieces.values())) == number(t.hello, 10) and t.pieces)
        joined = b"".join(text[k] for k in sorted(text))
        self.assertIn(b'name: "clutter"', joined)
        self.assertEqual(t.hello[7][0], b"clutter")
        self.assertEqual(number(t.hello, 8), 5)
        self.assertTrue(t.hello[11][0].startswith(b"full --threshold 0.014:0.012"))
        self.assertEqual(t.hello[12][0], b"delay 20ms")
        self.assertFalse(number(t.hello, 2), "nobody said --control")
        self.assertEqual(number(t.hello, 3), 0, "then there is no token either")
        self.assertGreater(t.frames[-1].total, 200)
        status = m.wait_until(lambda: t.status and number(t.status, 20) == 2 and t.status)
        self.assertEqual(len(status[23]), 1)

    def test_the_end_is_told(self):
        m, peers = self.told(2, "--duration", 3)
        t = m.slot(1)
        self.assertEqual([p.end() for p in peers], [0, 0])
        kinds = m.wait_until(lambda: [e["kind"] for e in t.events.values() if e["kind"] == "end"] and
                             [e["kind"] for e in t.events.values()])  # fmt: skip
        self.assertIn("life", kinds)
        summary = peers[1].summary()["monitor"]
        self.assertGreater(summary["datagrams"], 50)
        self.assertEqual(summary["untold"], 0)
        self.check_agreement(peers, 2)

    def test_a_monitor_that_comes_late_goes_and_comes_back(self):
        m = self.monitor()
        port = m.port()
        m.close()
        self.monitors.clear()
        peers = self.session(2, *QUIET, "--duration", 8, "--monitor", f"127.0.0.1:{port}")
        peers[1].wait_for(PLAYING)
        time.sleep(2)
        m = self.monitor(port)
        t = m.slot(1, 10)
        m.wait_until(lambda: sum(map(len, t.pieces.values())) == number(t.hello, 10))
        m.close()
        self.monitors.clear()
        time.sleep(1)
        m = self.monitor(port)
        m.slot(1, 10)
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, 4)

    def test_a_name_that_nobody_knows_does_not_matter(self):
        peers = self.session(2, *QUIET, "--duration", 3, "--monitor", "nobody.invalid:9200")
        peers[0].wait_for(r"nobody.invalid.*trying again")
        self.assertEqual([p.end() for p in peers], [0, 0])


class Obeying(MonitorCase):
    def test_an_avatar_is_driven_by_points_and_directions(self):
        m, peers = self.told(2, "--duration", 60, "--control", "--input", "rest", "--scenario", "proxy")
        t = m.slot(1)
        x, y = t.frames[-1].live[t.avatar()]
        number_ = m.drive(t, DIRECTION, -1, 0)
        self.assertEqual(m.answer(t, number_)["kind"], "drive")
        moved = m.wait_until(lambda: abs(t.frames[-1].live[t.avatar()][0] - x) > 0.5 and t.frames[-1])
        self.assertTrue(moved.driven)
        other = m.slot(0)
        m.wait_until(lambda: abs(other.frames[-1].shown[t.avatar()][0] - x) > 0.5)
        # Orders that are not repeated lapse, and the avatar stays where it is, for its own input stands still.
        end = m.wait_until(lambda: [e for e in t.events.values() if e["kind"] == "drive_end"])
        self.assertEqual(end[0]["order"], 0)
        m.drive(t, POINT, x, y)
        m.wait_until(lambda: [e for e in t.events.values() if e["kind"] == "drive"][1:])
        deadline = time.monotonic() + PATIENCE
        while True:
            order = m.drive(t, POINT, x, y)
            with m.lock:
                here = t.frames[-1].live[t.avatar()]
            if abs(here[0] - x) < 0.1 and abs(here[1] - y) < 0.1:
                break
            self.assertLess(time.monotonic(), deadline, f"from {here} to {(x, y)}")
            time.sleep(0.1)
        order = m.drive(t, RELEASE)
        self.assertEqual(m.answer(t, order)["kind"], "drive_end")

    def test_knobs_netem_and_pushes_are_followed_and_told(self):
        trace = os.path.join(self.folder.name, "one.trace")
        m, peers = self.told(2, "--duration", 8, "--control", own=[[], ["--trace", trace]])
        t = m.slot(1, 20)
        self.assertGreater(t.frames[-1].threshold, 0.004)
        self.assertLess(t.frames[-1].threshold, 0.014 * 47 + 0.001)
        order = m.knob(t, "threshold", "0.05")
        answer = m.answer(t, order)
        self.assertEqual((answer["kind"], answer["text"]), ("knob", "--threshold 0.05"))
        m.wait_until(lambda: abs(t.frames[-1].threshold - 0.05) < 1e-6)
        m.wait_until(lambda: b"--threshold 0.05 " in t.hello[11][0])
        for name, value in (("replay", "off"), ("convergence", "snap"), ("replay", "on"), ("technique", "adaptive"),
                            ("technique", "full")):  # fmt: skip
            self.assertEqual(m.answer(t, m.knob(t, name, value))["kind"], "knob")
        answer = m.answer(t, m.netem(t, 1, "delay 80ms"))
        self.assertEqual((answer["kind"], answer["text"], answer["peer"]), ("netem", "delay 80ms", 0))
        answer = m.answer(t, m.netem(t, 1, "trace mobile delay 40ms"))
        self.assertEqual((answer["kind"], answer["text"]), ("netem", "delay 40ms trace mobile"))
        answer = m.answer(t, m.push(t, 7, 2, 1))
        self.assertIn(answer["kind"], ("push", "refused"))
        for order, says in (
            (m.knob(t, "threshold", "wide"), "--threshold: 'wide' is not allowed"),
            (m.knob(t, "nonsense", "1"), "there is no such knob"),
            (m.knob(t, "technique", "avatar-only"), "another rule of authority"),
            (m.netem(t, 0, "delay"), "netem"),
            (m.netem(t, 1, "trace /etc/passwd"), "files can be named on a command line only"),
            (m.netem(t, 2, "delay 1ms"), "there is no other peer 1"),
            (m.cut(t, 20, 1), "there is no other peer 19"),
            (m.push(t, 60000, 1, 1), "there is none"),
        ):
            answer = m.answer(t, order)
            self.assertEqual(answer["kind"], "refused")
            self.assertIn(says, answer["text"])
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, 4)
        with open(trace, "rb") as f:
            recorded = f.read()
        self.assertIn(b"delay 80ms", recorded)

    def test_an_impaired_link_is_as_slow_as_was_ordered(self):
        m, _ = self.told(2, "--duration", 60, "--control")
        t, other = m.slot(1), m.slot(0)

        def delay():  # of what comes from the one to the other, ms
            return real(fields(other.status[23][0]), 5) if other.status and 23 in other.status else None

        m.wait_until(lambda: delay() is not None and delay() < 40)
        m.answer(t, m.netem(t, 0, "delay 120ms"))
        m.wait_until(lambda: 100 < delay() < 160)
        self.assertEqual(fields(t.status[23][0])[9][0], b"delay 120ms")
        m.answer(t, m.netem(t, 1, ""))
        m.wait_until(lambda: delay() < 40)

    def test_a_cut_ends_and_all_agree_again(self):
        m, peers = self.told(3, "--duration", 9, "--control")
        t = m.slot(2, 40)
        self.assertEqual(m.answer(t, m.cut(t, 0, 2))["kind"], "cut")
        m.wait_until(lambda: t.status and all(number(fields(link), 3) & 12 == 12 for link in t.status[23]))
        m.wait_until(lambda: [e for e in t.events.values() if e["kind"] == "cut_end"])
        self.assertEqual([p.end() for p in peers], [0, 0, 0])
        self.check_agreement(peers, 4)
        self.assertEqual(len(peers[2].summary()["lives"]), 1, "two seconds are no reason to be declared gone")

    # The session has it at the relay, and it was cut there only.
    def test_a_cut_holds_where_a_peer_with_a_key_really_is(self):
        m = self.monitor()
        env = {**os.environ, "PADR_KEY": "22" * 32}
        flags = [*QUIET, "--monitor", f"127.0.0.1:{m.port()}", "--control", "--duration", 25]
        founder = self.peer("--wait-peers", 3, *flags, env=env)
        relay = Relay(founder.port())
        self.addCleanup(relay.close)
        behind = self.peer("--join", f"127.0.0.1:{relay.port()}", *flags, env=env)
        behind.wait_for("welcomed|this is peer")
        other = self.peer("--join", f"127.0.0.1:{founder.port()}", *flags, env=env)
        t = m.slot(2, 40)
        self.assertEqual(m.answer(t, m.cut(t, 1 + 1, 30))["kind"], "cut")  # 0 is everybody
        other.wait_for("peer 1 is reached through peer 0: the link to it is silent")
        other.process.send_signal(signal.SIGINT)
        self.assertEqual(other.end(), 0)
        link = next(x for x in other.summary()["links"] if x["peer"] == 1)
        self.assertEqual(link["endpoint"], f"127.0.0.1:{behind.port()}", "where it is, not where the relay is")

    def test_a_pause_ends_and_all_agree_again(self):
        m, peers = self.told(2, "--duration", 9, "--control")
        t = m.slot(1, 40)
        self.assertEqual(m.answer(t, m.pause(t, 2))["kind"], "pause")
        m.wait_until(lambda: t.status and number(t.status, 21))
        with m.lock:
            before = len(t.frames)
        time.sleep(0.5)
        with m.lock:
            self.assertLessEqual(len(t.frames), before + 1)
        m.wait_until(lambda: [e for e in t.events.values() if e["kind"] == "pause_end"])
        m.wait_until(lambda: len(t.frames) > before + 40)
        self.assertEqual(m.answer(t, m.pause(t, 500))["kind"], "pause")
        self.assertEqual(m.answer(t, m.pause(t, 0))["kind"], "pause_end")
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.check_agreement(peers, 4)
        self.assertLess(peers[1].summary()["late_ticks"], 60, "to stand still by order is not to be late")

    def test_a_paused_peer_says_goodbye_when_it_is_stopped(self):
        m, peers = self.told(2, "--duration", 60, "--control")
        t = m.slot(1, 20)
        m.answer(t, m.pause(t, 500))
        time.sleep(1)
        peers[1].process.send_signal(signal.SIGTERM)
        self.assertEqual(peers[1].end(), 0)
        other = m.slot(0)
        m.wait_until(lambda: [e for e in other.events.values() if e["kind"] == "left" and e["peer"] == 1])

    def test_a_long_pause_is_survived_as_a_stopped_process_is(self):
        m, peers = self.told(3, "--duration", 30, "--control")
        t = m.slot(2, 40)
        m.answer(t, m.pause(t, 9))
        other = m.slot(0)
        m.wait_until(lambda: [e for e in other.events.values() if e["kind"] == "removed" and e["peer"] == 2])
        m.wait_until(lambda: [e for e in other.events.values() if e["kind"] == "joined" and e["peer"] == 2], 40)
        self.assertEqual([p.end(60) for p in peers], [0, 0, 0])
        self.check_agreement(peers, 4)


class Hostile(MonitorCase):
    def test_orders_that_do_not_count_are_dropped(self):
        m, peers = self.told(2, "--duration", 6, "--control", "--input", "rest")
        t = m.slot(1)
        other = m.slot(0)
        first = m.knob(t, "threshold", "0.4")
        m.answer(t, first)
        accepted = 1
        for altered in ({"token": t.token ^ 1}, {"token": other.token}, {"process": other.process}, {"issuer": 0},
                        {"number": first}, {"number": 0}):  # fmt: skip
            m.drive(t, DIRECTION, 1, 0, **altered)
        # From elsewhere, though everything in it is right.
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            own, m.socket = m.socket, s
            m.drive(t, DIRECTION, 1, 0)
            m.socket = own
            for garbage in (b"", b"PMON", PREAMBLE, PREAMBLE + b"\xff" * 1195, os.urandom(1400)):
                s.sendto(garbage, t.address)
        for garbage in (b"", PREAMBLE, PREAMBLE + os.urandom(300), b"x" * 60000, PREAMBLE + put(8, put(99, 1))):
            m.socket.sendto(garbage, t.address)
        for x in (float("nan"), float("inf"), 2.0, -1.5):
            m.drive(t, DIRECTION, x, 0)
        m.drive(t, 3, 0, 0)
        m.push(t, 3, float("nan"), 0)
        m.push(t, 3, 1000, 0)
        m.push(t, 70000, 1, 0)
        m.cut(t, 0, float("inf"))
        m.cut(t, 99, 1)
        m.pause(t, -1)
        m.knob(t, "x" * 500, "1")
        m.netem(t, 0, "delay " + "9" * 600)
        self.assertEqual(m.answer(t, m.knob(t, "threshold", "0.3"))["kind"], "knob")
        accepted += 1
        self.assertFalse([e for e in t.events.values() if e["kind"] in ("drive", "cut", "pause", "push")])
        self.assertEqual([p.end() for p in peers], [0, 0])
        summary = peers[1].summary()["monitor"]
        self.assertEqual(summary["orders"], accepted)
        self.assertGreater(summary["rejected"], 25)
        self.check_agreement(peers, 4)

    def test_without_control_nothing_is_obeyed(self):
        m, peers = self.told(2, "--duration", 5)
        t = m.slot(1, 10)
        m.pause(t, 100)
        m.drive(t, DIRECTION, 1, 0, token=0)
        self.assertEqual([p.end() for p in peers], [0, 0])
        self.assertEqual(peers[1].summary()["monitor"]["orders"], 0)
        self.assertEqual(peers[1].summary()["monitor"]["rejected"], 2)

    def test_another_monitor_in_its_place_is_obeyed_too(self):
        m, _ = self.told(2, "--duration", 60, "--control")
        t = m.slot(1)
        m.order_number = 100
        m.answer(t, m.knob(t, "threshold", "0.4"))
        port = m.port()
        m.close()
        self.monitors.clear()
        m = self.monitor(port)
        m.issuer += 2
        t = m.slot(1)
        self.assertEqual(m.answer(t, m.knob(t, "threshold", "0.3"))["order"], 1)


class Usage(unittest.TestCase):
    def refused(self, *arguments):
        code, out, err = run(*arguments)
        self.assertEqual((code, out), (2, ""), err)
        self.assertEqual(err.count("\n"), 1, err)
        return err

    def test_what_makes_no_sense_is_refused(self):
        self.assertIn("--control: there is no monitor to obey", self.refused("--control"))
        self.assertIn("--monitor", self.refused("--monitor", "here"))
        self.assertIn("--monitor-rate", self.refused("--monitor", "127.0.0.1:1", "--monitor-rate", "0"))
        self.assertIn("--monitor-rate", self.refused("--monitor", "127.0.0.1:1", "--monitor-rate", "61"))
        self.assertIn("shown, live, all", self.refused("--monitor", "127.0.0.1:1", "--monitor-detail", "much"))
        self.assertIn("--monitor-detail: there is no monitor to tell", self.refused("--monitor-detail", "shown"))
        self.assertIn("nothing proves who sends orders", self.refused("--monitor", "192.0.2.1:9200", "--control"))


if __name__ == "__main__":
    main()
