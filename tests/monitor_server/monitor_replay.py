"""padr-monitor plays what real peers have recorded: traces and packet captures."""

import os
import signal
import time

from monitors import MonitorCase, Page, main, refused
from peers import PLAYING

SECONDS = 6


class Replaying(MonitorCase):
    def recorded(self, count=3):
        """A folder with traces and captures of peers, and a summary of one."""
        folder = self.folder.name
        own = [["--trace", os.path.join(folder, f"peer{i}.trace"), "--pcap", os.path.join(folder, f"peer{i}.pcapng")]
               for i in range(count)]  # fmt: skip
        played = self.session(count, "--status-interval", 0, "--scenario", "arena", "--duration", SECONDS,
                              "--netem", "delay 60ms 20ms loss 5%", own=own)  # fmt: skip
        self.assertEqual([p.end() for p in played], [0] * count)
        return folder, played[0].summary()

    def test_traces_play_back_with_every_view(self):
        folder, summary = self.recorded()
        m = self.monitor("--trace", folder)
        page = self.page(m)
        page.say(type="subscribe", views=["shown", "live", "predicted", "confirmed", "authority"], rate=60)
        self.assertEqual(page.wait("hello")["mode"], "trace")
        scene = page.wait("scene")
        bodies = len(scene["bodies"])
        line = page.wait("timeline")
        self.assertGreaterEqual(line["last"], SECONDS * 60 - 30)
        self.assertEqual(line["sample"], 1)
        history = page.wait("history")
        self.assertGreater(len(history["points"]), 3 * SECONDS)
        self.assertGreater(sum(q["combined_m"] is not None for p in history["points"] for q in p["peers"]), 6 * SECONDS)
        self.assertGreater(sum(q["fidelity_m"] is not None for p in history["points"] for q in p["peers"]), 6 * SECONDS)
        self.assertGreater(len(page.events()), 5)
        self.assertFalse([e for e in page.events() if "differently" in e["text"]])
        for slot in range(3):
            for which in (Page.SHOWN, Page.LIVE, Page.PREDICTED, Page.CONFIRMED):
                page.wait_view(slot, which, lambda v: len(v.records) == bodies + 3)
        page.wait_view(255, Page.AUTHORITY)
        table = page.wait("peers", lambda t: t["agreement"]["compared"] > 20)
        self.assertEqual(table["agreement"]["state"], "identical")
        self.assertRegex(table["peers"][0]["version"], r"^\S+ of padr-peer$")
        self.assertEqual(page.ask(type="drive", peer=0, direction=[1, 0])["ok"], False)
        page.wait("timeline", lambda t: not t["playing"] and t["tick"] == t["last"], patience=2 * SECONDS + 30)
        # The agreed world shown is the one that the peers agreed on.
        checkpoints = summary["confirmed"]["checkpoints"]
        told = {q["confirmed"]["tick"]: q["confirmed"]["hash"] for t in page.all("peers") for q in t["peers"] if q["confirmed"]}
        common = [t for t in told if str(t) in checkpoints]
        for tick in common:
            self.assertEqual(told[tick], checkpoints[str(tick)])

    def test_ticks_that_are_late_while_a_peer_waits_count_for_nobody(self):
        trace = os.path.join(self.folder.name, "founder.trace")
        founder = self.peer("--listen", "127.0.0.1:0", "--wait-peers", 2, "--duration", 2, "--trace", trace)
        port = founder.port()
        time.sleep(0.5)
        founder.process.send_signal(signal.SIGSTOP)
        time.sleep(1)
        founder.process.send_signal(signal.SIGCONT)
        time.sleep(0.5)
        other = self.peer("--join", f"127.0.0.1:{port}", "--duration", 2)
        self.assertEqual([founder.end(), other.end()], [0, 0])
        page = self.page(self.monitor("--trace", trace))
        page.ask(type="seek", tick=10**9)
        table = page.wait("peers", lambda t: t["tick"] > 100)
        self.assertLessEqual(table["peers"][0]["late_ticks"], founder.summary()["late_ticks"])

    def test_the_timeline_obeys(self):
        folder, _ = self.recorded(2)
        m = self.monitor("--trace", *[os.path.join(folder, f"peer{i}.trace") for i in range(2)])
        page = self.page(m)
        page.say(type="subscribe", rate=60)
        self.assertEqual(page.wait("hello")["source"], os.path.join(folder, "peer0.trace") + " and 1 more")
        at = page.wait("timeline")["first"] + 60  # it begins with play, later on a slow machine
        self.assertTrue(page.ask(type="halt")["ok"])
        self.assertTrue(page.ask(type="seek", tick=at)["ok"])
        self.assertEqual(page.all("timeline")[-1]["tick"], at)
        page.wait_view(0, 0, lambda v: v.tick == at)
        page.ask(type="step", ticks=1)
        page.wait_view(1, 0, lambda v: v.tick == at + 1)
        page.ask(type="step", ticks=-2)
        page.wait_view(1, 0, lambda v: v.tick == at - 1)
        line = page.all("timeline")[-1]
        self.assertEqual((line["tick"], line["playing"]), (at - 1, False))
        page.ask(type="seek", tick=10**9)
        self.assertEqual(page.all("timeline")[-1]["tick"], line["last"])
        page.ask(type="seek", tick=at)
        page.ask(type="speed", speed=4)
        self.assertTrue(page.ask(type="play")["ok"])
        page.wait("timeline", lambda t: t["playing"] and t["speed"] == 4)
        page.wait("timeline", lambda t: t["tick"] == t["last"])
        page.ask(type="play")
        page.wait("timeline", lambda t: t["playing"] and t["tick"] < t["first"] + 60)  # from the beginning again
        late = self.page(m)
        late.wait("scene")
        late.wait("timeline")
        self.assertEqual(m.session()["peers"]["type"], "peers")
        self.assertEqual(m.get("/metrics")[0], 200)

    def test_a_trace_that_breaks_off_plays_as_far_as_it_goes(self):
        folder, _ = self.recorded(2)
        path = os.path.join(folder, "peer1.trace")
        with open(path, "r+b") as f:
            f.truncate(os.path.getsize(path) // 2)
        m = self.monitor("--trace", folder)
        page = self.page(m)
        page.wait_view(1)
        self.assertGreaterEqual(page.wait("timeline")["last"], SECONDS * 60 - 30)

    # Once, only the last life was seen: it took the slot before the first had begun.
    def test_all_lives_of_a_peer_that_came_back_are_seen(self):
        own = [["--trace", os.path.join(self.folder.name, f"peer{i}.trace")] for i in range(3)]
        played = self.session(3, "--status-interval", 0, "--scenario", "arena", "--duration", 15, own=own)
        played[2].wait_for(PLAYING)
        time.sleep(2)
        played[2].process.send_signal(signal.SIGSTOP)
        time.sleep(6)  # so that its slot is free again
        played[2].process.send_signal(signal.SIGCONT)
        self.assertEqual([p.end() for p in played], [0] * 3)
        self.assertTrue(os.path.exists(os.path.join(self.folder.name, "peer2.2.trace")))
        page = self.page(self.monitor("--trace", self.folder.name))
        page.say(type="subscribe", rate=60)
        line = page.wait("timeline")
        page.ask(type="halt")
        lives = set()
        for tick in (line["first"] + 60, line["last"] - 60):
            self.assertTrue(page.ask(type="seek", tick=tick)["ok"])
            table = page.wait("peers", lambda t: abs(t["tick"] - tick) < 20)
            here = [p for p in table["peers"] if p["state"] == "here"]
            self.assertEqual(len(here), 3, f"at tick {tick}")
            for p in here:
                page.wait_view(p["slot"], 0, lambda v: v.tick == tick)
            lives.update(p["incarnation"] for p in here)
        self.assertEqual(len(lives), 4)
        early = [p["peers"] for p in page.wait("history")["points"] if p["tick"] < line["first"] + 90]
        self.assertTrue(any(all(q["combined_m"] is not None for q in ps) for ps in early), "errors of first lives are measured")

    def test_traces_of_several_sessions_are_refused(self):
        folder, _ = self.recorded(1)
        other = self.peer("--wait-peers", 1, "--duration", 1, "--scenario", "ball",
                          "--trace", os.path.join(folder, "ball.trace"))  # fmt: skip
        self.assertEqual(other.end(), 0)
        code, said = refused("--trace", folder)
        self.assertEqual(code, 2)
        self.assertIn("is of another session than", said)

    def test_a_capture_plays_back_as_the_agreed_world(self):
        folder, _ = self.recorded(2)
        m = self.monitor("--capture", os.path.join(folder, "peer0.pcapng"), os.path.join(folder, "peer1.pcapng"))
        page = self.page(m)
        page.say(type="subscribe", views=["confirmed"])
        self.assertEqual(page.wait("hello")["mode"], "capture")
        bodies = len(page.wait("scene")["bodies"])
        page.wait_view(255, Page.CONFIRMED, lambda v: len(v.records) == bodies + 2 and v.tick > 60)
        self.assertGreaterEqual(page.wait("timeline")["last"], SECONDS * 60 - 60)
        self.assertTrue(any(line.endswith("agree") for line in m.log))


if __name__ == "__main__":
    main()
