#!/usr/bin/env python3
"""Recordings on the page: traces of real peers, played, halted, stepped through; and a capture. See browser.py."""

from browser import *
from selenium.webdriver.common.keys import Keys

PEERS = 3
SECONDS = 12


class Replay(Case):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        monitor = Monitor()
        own = [["--trace", os.path.join(folder.name, f"peer{i}.trace"), "--input", f"wander:{i}"] for i in range(PEERS)]
        session = Session(monitor, PEERS, "--netem", "delay 40ms 10ms", own=own)
        session.peers[0].wait_for(r"status:\s+%d\.\d s" % SECONDS)
        left = session.end()
        assert left == [0] * PEERS, left
        assert monitor.end() == 0
        cls.monitor = cls.start(Monitor("--trace", folder.name))
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def setUp(self):
        b = self.browser
        wait(lambda: b.script("return padr.session.timeline && padr.session.present().length") == PEERS, "the recording")

    def tick(self):
        return self.browser.script("return padr.session.timeline.tick")

    def halt(self):
        b = self.browser
        if b.script("return padr.session.timeline.playing"):
            b.find("#replay .play").click()
        wait(lambda: not b.script("return padr.session.timeline.playing"), "it to stand")

    def test_it_plays(self):
        b = self.browser
        self.assertFalse(b.script("return document.querySelector('#replay').hidden"))
        b.script("padr.connection.send({ type: 'seek', tick: padr.session.timeline.first + 60 })")
        if not b.script("return padr.session.timeline.playing"):
            b.find("#replay .play").click()
        prints = "return [...document.querySelectorAll('#views canvas')].map((c) => c.toDataURL())"
        start, before = self.tick(), b.script(prints)
        wait(lambda: self.tick() > start + 60, "a second to be played")
        self.assertTrue(all(x != y for x, y in zip(before, b.script(prints))))
        wait(lambda: "identical" in b.text("#verdict"), "hashes to be compared")
        b.picture("replay")
        b.script("document.querySelector('#plots').scrollIntoView()")
        wait(lambda: min(b.script("return padr.plots.charts.map((c) => c.graph ? c.graph.numRows() : 0)")) > 10, "plots of all of it")
        b.picture("replay-plots")
        b.script("scrollTo(0, 0)")
        self.check_console(b)

    def test_slider_steps_and_speed(self):
        b = self.browser
        self.halt()
        slider = b.find("#replay input")
        slider.click()  # into the middle
        middle = b.script("const t = padr.session.timeline; return (t.first + t.last) / 2")
        wait(lambda: abs(self.tick() - middle) < 30, "the middle")
        sample = b.script("return padr.session.timeline.sample")
        for step, by in (("1", 1), ("-1", -1), ("60", 60), ("-60", -60)):
            was = self.tick()
            b.find(f'#replay [data-step="{step}"]').click()
            wait(lambda: abs(self.tick() - was - by) < max(1, sample) and self.tick() != was, f"{by} ticks")
        # The views show that very tick.
        tick = self.tick()
        wait(lambda: abs(b.script("return padr.session.samples.now ?? -1e9") - tick) <= max(1, sample), "the views to be there")
        slider.send_keys(Keys.HOME)
        wait(lambda: self.tick() == b.script("return padr.session.timeline.first"), "the beginning")
        b.script("const s = document.querySelector('#replay select'); s.value = '4'; s.dispatchEvent(new Event('change'))")
        wait(lambda: b.script("return padr.session.timeline.speed") == 4, "four times as fast")
        b.script("const s = document.querySelector('#replay select'); s.value = '1'; s.dispatchEvent(new Event('change'))")
        self.check_console(b)

    def test_nothing_can_be_driven_in_it(self):
        b = self.browser
        self.assertEqual(b.script("return padr.session.controllable().length"), 0)
        self.assertTrue(b.script("return document.querySelector('#knobs').hidden"))


class Capture(Case):
    """The agreed world, rebuilt from the packets that one peer saw."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        capture = os.path.join(folder.name, "peer0.pcapng")
        monitor = Monitor()
        session = Session(monitor, 2, own=[["--pcap", capture], []])
        session.peers[0].wait_for(r"status:\s+5\.\d s")
        session.end()
        monitor.end()
        cls.monitor = cls.start(Monitor("--capture", capture))
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def test_the_agreed_world_moves(self):
        b = self.browser
        wait(lambda: b.script("return padr.session.timeline && padr.session.samples.sample(255, 3) && true"), "the recording")
        b.script("padr.connection.send({ type: 'seek', tick: 100 }); padr.connection.send({ type: 'play' })")
        drawn = "return document.querySelector('#views canvas').toDataURL()"
        before = b.script(drawn)
        wait(lambda: b.script(drawn) != before, "the canvas to change")
        b.picture("capture")
        self.check_console(b)


if __name__ == "__main__":
    main()
