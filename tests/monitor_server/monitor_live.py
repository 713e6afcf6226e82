"""padr-monitor with real peers: it shows the truth, and peers obey the page's orders."""

import csv
import io
import math
import signal
import time

from monitors import MonitorCase, Page, main, wait_until

CALM = ["--duration", 60]



class Watching(MonitorCase):
    def test_a_session_appears_with_all_there_is_to_know_of_it(self):
        m = self.monitor()
        early = self.page(m)
        early.say(type="subscribe", views=["shown", "live", "predicted", "confirmed", "authority"], rate=60)
        early.wait("hello")
        self.watched(m, 3, *CALM, "--netem", "delay 40ms")
        scene = early.wait("scene")
        self.assertEqual((scene["name"], scene["tick_rate"]), ("arena", 60))
        bodies = len(scene["bodies"])
        for slot in range(3):
            for which in (Page.SHOWN, Page.LIVE, Page.PREDICTED, Page.CONFIRMED):
                view = early.wait_view(slot, which, lambda v: len(v.records) == bodies + 3)
                self.assertEqual(view.records[bodies + slot][0], slot, "an avatar is its peer's")
        early.wait_view(255, Page.AUTHORITY, lambda v: len(v.records) == bodies + 3)
        peers = early.wait("peers", lambda p: p["agreement"]["state"] == "identical" and len(p["peers"]) == 3 and
                           all(q["rates"] and q["links"] for q in p["peers"]))  # fmt: skip
        for q in peers["peers"]:
            self.assertEqual((q["state"], q["technique"], q["controllable"]), ("here", "full", False))
            self.assertEqual(q["confirmed"]["state"], "identical")
            self.assertEqual(q["knobs"]["threshold"], "0.014:0.012")
            self.assertEqual({link["netem"] for link in q["links"]}, {"delay 40ms"})
        early.wait("series", lambda p: len(p["peers"]) == 3 and
                   all(q["combined_m"] is not None and len(q["delay_ms"]) == 2 and
                       all(30 < d < 120 for d in q["delay_ms"].values()) for q in p["peers"]))  # fmt: skip
        self.assertIn("life", [e["kind"] for e in early.events()])
        wait_until(lambda: len(early.all("series")) > 8, "two seconds of moments")
        late = self.page(m)
        late.wait("history", lambda h: len(h["points"]) > 3)
        late.wait_view(2)
        self.assertEqual({k for k, _ in late.views if k == 255}, set(), "nobody asked for the authority's view")

    def test_views_come_at_the_rate_asked_for(self):
        m = self.monitor()
        self.watched(m, 2, *CALM)
        fast, slow = self.page(m), self.page(m)
        fast.say(type="subscribe", rate=60)
        slow.say(type="subscribe", rate=2)
        fast.wait_view(0)
        slow.wait_view(0)
        before = fast.binaries, slow.binaries
        time.sleep(3)
        self.assertGreater(fast.binaries - before[0], 30)
        self.assertLessEqual(slow.binaries - before[1], 8)
        self.assertGreaterEqual(slow.binaries - before[1], 3)

    def test_metrics_and_json_are_for_programs(self):
        m = self.monitor()
        self.watched(m, 2, *CALM)
        wait_until(lambda: 'padr_peer_agrees{peer="1"}' in m.metrics(), "agreement in the metrics")
        wait_until(lambda: 'padr_peer_inconsistency_metres{peer="1",part="bodies"}' in m.metrics(), "inconsistency")
        wait_until(lambda: m.metrics()['padr_peer_steps_total{peer="0"}'] > 10, "steps")
        values = m.metrics()
        self.assertEqual(values['padr_peer_up{peer="0",incarnation="0"}'], 1)
        self.assertEqual(values['padr_peer_agrees{peer="0"}'], 1)
        self.assertGreater(values["padr_monitor_datagrams_total"], 20)
        self.assertEqual(values["padr_monitor_malformed_datagrams_total"], 0)
        session = m.session()
        self.assertEqual(len(session["peers"]["peers"]), 2)
        self.assertEqual(session["scene"]["name"], "arena")
        self.assertEqual(session["series"]["type"], "series")

    def test_who_ends_is_gone_and_a_session_that_begins_is_shown(self):
        m = self.monitor()
        page = self.page(m)
        first = self.watched(m, 2, "--scenario", "arena", "--duration", 4)
        self.assertEqual(page.wait("scene")["name"], "arena")
        self.assertEqual([p.end() for p in first], [0, 0])
        page.wait("peers", lambda t: t["peers"] and all(q["state"] == "gone" for q in t["peers"]))
        self.watched(m, 2, "--scenario", "ball", "--duration", 20)
        page.wait("scene", lambda s: s["name"] == "ball")
        page.wait("peers", lambda t: t["session"] == page.all("scene")[-1]["session"] and len(t["peers"]) == 2)

    def test_a_peer_that_is_killed_and_one_that_takes_its_place(self):
        m = self.monitor()
        page = self.page(m)
        played = self.watched(m, 3, *CALM)
        page.wait("peers", lambda t: len(t["peers"]) == 3)
        played[2].process.kill()
        page.wait("peers", lambda t: [q["state"] for q in t["peers"]].count("gone") == 1)
        self.peer("--join", f"127.0.0.1:{played[0].port()}", "--status-interval", 0, "--monitor", m.heard_at(), *CALM)
        page.wait("peers", lambda t: [q["state"] for q in t["peers"]].count("here") == 3 and
                  any(q["incarnation"] > 0 and q["state"] == "here" for q in t["peers"]))  # fmt: skip

    def test_peers_do_not_mind_a_monitor_that_restarts(self):
        m = self.monitor()
        self.watched(m, 2, *CALM)
        self.page(m).wait("scene")
        heard = m.heard_at()
        m.process.kill()
        m.process.wait()
        again = self.monitor(heard=heard)
        page = self.page(again)
        self.assertEqual(page.wait("scene")["name"], "arena")
        page.wait_view(1)

    def test_a_page_that_does_not_read_misses_views_and_nothing_else(self):
        m = self.monitor()
        self.watched(m, 2, *CALM, "--scenario", "clutter")
        stuck = self.page(m, read=False)
        stuck.say(type="subscribe", views=["shown", "live", "predicted", "confirmed", "authority"], rate=60)
        page = self.page(m)
        page.wait_view(1)
        wait_until(lambda: m.metrics()["padr_monitor_skipped_messages_total"] > 50, "messages that were left out")
        memory = m.memory()
        time.sleep(3)
        self.assertLess(m.memory() - memory, 4 << 20, "what waits is bounded")
        ticks = page.newest(0).tick
        page.wait_view(0, Page.SHOWN, lambda v: v.tick > ticks + 60)


class Controlling(MonitorCase):
    def controlled(self, count=2, *arguments):
        m = self.monitor()
        played = self.watched(m, count, *CALM, "--control", "--input", "rest", *arguments)
        page = self.page(m)
        page.say(type="subscribe", views=["shown"], rate=60)
        page.wait("peers", lambda t: len(t["peers"]) == count and all(q["controllable"] for q in t["peers"]))
        bodies = len(page.wait("scene")["bodies"])
        return m, page, played, bodies

    def test_a_page_drives_an_avatar_in_all_views(self):
        m, page, _, bodies = self.controlled()
        avatar = bodies + 1
        start = [page.wait_view(slot).records[avatar][2:4] for slot in (0, 1)]
        stop = time.monotonic() + 30
        moved = [False, False]
        while time.monotonic() < stop and not all(moved):
            self.assertTrue(page.ask(type="drive", peer=1, direction=[1, 0])["ok"])
            for slot in (0, 1):
                moved[slot] = moved[slot] or page.newest(slot).records[avatar][2] > start[slot][0] + 0.5
            time.sleep(0.05)
        self.assertEqual(moved, [True, True])
        page.until("peers", lambda t: t["peers"][1]["driven"] == "you")
        self.assertTrue(page.newest(1).flags & 4, "driven from a page")
        self.assertTrue(page.ask(type="drive", peer=1, release=True)["ok"])
        page.until("peers", lambda t: t["peers"][1]["driven"] == "no")
        wait_until(lambda: "drive_end" in [e["kind"] for e in page.events()], "its end")
        status, headers, body = m.get("/api/path?peer=1")
        self.assertEqual(status, 200)
        self.assertTrue(headers["Content-Type"].startswith("text/csv"))
        rows = list(csv.DictReader(io.StringIO(body.decode())))
        self.assertGreater(len(rows), 5)
        times = [float(r["t"]) for r in rows]
        self.assertEqual(times[0], 0)
        self.assertEqual(times, sorted(set(times)))
        path = self.file("driven.csv", body)
        again = self.peer("--wait-peers", 1, "--duration", 1, "--input", f"path:{path}")
        self.assertEqual(again.end(), 0, "every program takes it")
        self.assertEqual(m.get("/api/path?peer=0")[0], 404)

    def test_a_page_that_goes_releases_what_it_drove(self):
        m, page, _, _ = self.controlled()
        other = self.page(m)
        other.wait("scene")
        other.ask(type="drive", peer=0, direction=[0, 1])
        page.until("peers", lambda t: t["peers"][0]["driven"] == "other")
        other.close()
        page.until("peers", lambda t: t["peers"][0]["driven"] == "no")

    def test_who_comes_last_drives(self):
        m, page, _, _ = self.controlled()
        other = self.page(m)
        other.wait("scene")
        page.ask(type="drive", peer=0, direction=[0, 1])
        other.ask(type="drive", peer=0, direction=[0, -1])
        self.assertEqual(page.wait("taken")["peer"], 0)
        self.assertFalse(page.ask(type="drive", peer=0, release=True)["ok"])
        self.assertTrue(other.ask(type="drive", peer=0, release=True)["ok"])

    def test_knobs_netem_cut_pause_and_push_are_done_and_told(self):
        m, page, _, _ = self.controlled(3)
        self.assertTrue(page.ask(type="knob", peer="all", name="threshold", value="0.5:0.2")["ok"])
        page.wait("peers", lambda t: all(q["knobs"]["threshold"] == "0.5:0.2" for q in t["peers"]))
        self.assertTrue(page.ask(type="knob", peer=1, name="technique", value="adaptive")["ok"])
        page.until("peers", lambda t: t["peers"][1]["technique"] == "adaptive" and t["peers"][0]["technique"] != "adaptive")
        doubtful = page.ask(type="netem", peer="all", to="all", spec="delay 1")
        self.assertTrue(doubtful["ok"])
        self.assertIn("microseconds", doubtful["text"])
        doubtless = page.ask(type="netem", peer="all", to="all", spec="delay 150ms")
        self.assertEqual((doubtless["ok"], doubtless["text"]), (True, ""))
        page.wait("series", lambda s: s["peers"] and all(d > 120 for q in s["peers"] for d in q["delay_ms"].values()))
        self.assertTrue(page.ask(type="netem", peer="all", to="all", spec="")["ok"])
        self.assertTrue(page.ask(type="cut", peer=2, **{"with": 0}, seconds=1)["ok"])
        page.until("peers", lambda t: any(link["cut"] for link in t["peers"][2]["links"]))
        page.until("peers", lambda t: not any(link["cut"] for q in t["peers"] for link in q["links"]))
        self.assertTrue(page.ask(type="cut", peer=2, **{"with": 0}, seconds=1, ways="out")["ok"])
        page.until("peers", lambda t: any(link["cut"] == "out" for link in t["peers"][2]["links"]))
        page.until("peers", lambda t: not any(link["cut"] for q in t["peers"] for link in q["links"]))
        self.assertTrue(page.ask(type="push", peer="any", body=3, velocity=[4, 0])["ok"])
        self.assertTrue(page.ask(type="pause", peer=1, on=True)["ok"])
        page.until("peers", lambda t: t["peers"][1]["paused"])
        self.assertTrue(page.ask(type="pause", peer=1, on=False)["ok"])
        page.until("peers", lambda t: not t["peers"][1]["paused"])
        told = {e["kind"] for e in page.events()}
        self.assertLessEqual({"knob", "netem", "cut", "push", "pause", "pause_end"}, told)
        page.wait("peers", lambda t: t["agreement"]["state"] == "identical")

    def test_who_is_cut_off_is_apart_and_differs_from_nobody(self):
        m, page, _, _ = self.controlled(3)
        page.wait("peers", lambda t: t["agreement"]["state"] == "identical")
        self.assertTrue(page.ask(type="cut", peer=2, **{"with": "all"}, seconds=6)["ok"])
        page.until("peers", lambda t: t["agreement"]["state"] == "apart")
        page.until("peers", lambda t: len(t["peers"]) == 3 and all(q["confirmed"] and q["confirmed"]["state"] == "identical" for q in t["peers"]))
        states = [t["agreement"]["state"] for t in page.all("peers")]
        self.assertNotIn("differs", states)
        self.assertIsNone(page.all("peers")[-1]["agreement"]["first_difference"])

    def test_what_cannot_be_done_is_said(self):
        m, page, played, _ = self.controlled()
        self.assertIn("no such peer", page.ask(type="pause", peer=9, on=True)["text"])
        self.assertIn("none of that number", page.ask(type="push", peer=0, body=60000, velocity=[1, 0])["text"])
        self.assertIn("--threshold", page.ask(type="knob", peer=0, name="threshold", value="1000")["text"])
        self.assertIn("recordings", page.ask(type="play")["text"])
        played[1].process.send_signal(signal.SIGSTOP)
        try:
            answer = page.ask(type="knob", peer="all", name="lead", value="0.2")
        finally:
            played[1].process.send_signal(signal.SIGCONT)
        self.assertEqual((answer["ok"], answer["text"]), (False, "peer 1: does not answer"))
        self.peer("--join", f"127.0.0.1:{played[0].port()}", *CALM, "--spectate", "--control", "--monitor", m.heard_at())
        page.wait("peers", lambda t: len(t["peers"]) == 3 and t["peers"][2]["controllable"])
        self.assertIn("spectator", page.ask(type="drive", peer=2, direction=[1, 0])["text"])
        self.assertEqual(m.get("/api/path?peer=2")[0], 404)
        closed = self.monitor()
        self.watched(closed, 2, *CALM)
        other = self.page(closed)
        other.wait("peers", lambda t: len(t["peers"]) == 2)
        self.assertIn("--control", other.ask(type="drive", peer=0, direction=[1, 0])["text"])


if __name__ == "__main__":
    main()
