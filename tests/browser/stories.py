#!/usr/bin/env python3
"""Recordings that come along: opened without any peer, the same as the lab plays, and shared as a link. See browser.py."""

import shlex
import subprocess

from browser import *

LAB = os.path.join(os.path.dirname(os.path.abspath(MONITOR)), "padr-lab")
TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PRINTS = "return [...document.querySelectorAll('#views canvas')].map((c) => c.toDataURL())"
HASHES = "return padr.session.peers.peers.map((p) => [p.confirmed.tick, p.confirmed.hash])"


class Stories(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        cls.browser = cls.start(Browser(1280, 757))

    def open(self, end, browser=None):
        b = browser or self.browser
        b.open(self.monitor.address + end)
        if "sample=" in end and "nothing" not in end:
            wait(lambda: b.script("return padr.session.timeline && padr.session.present().length"), "the recording")
        return b

    def at(self, tick, b):
        wait(lambda: b.script("const s = padr.session; return s.timeline.tick === arguments[0] && s.samples.now === arguments[0]", tick), f"tick {tick}")

    def test_a_story_is_chosen_and_plays(self):
        b = self.open("")
        wait(lambda: b.script("return document.querySelectorAll('#stories li').length") >= 5, "the list of stories")
        self.assertTrue(b.script("return document.querySelector('#stories').open"))
        b.picture("stories")
        clicked = time.monotonic()
        b.find('#stories a[href="?sample=stop-short"]').click()
        wait(lambda: b.script("return window.padr && padr.session.timeline && padr.session.timeline.tick > 60"), "the story to play")
        first = b.script("return padr.session.timeline.tick")
        most = 60 * (time.monotonic() - clicked + 1)  # what can have been played since, on a machine of any speed
        self.assertLess(first, most, "it begins at its beginning")
        before = b.script(PRINTS)
        self.assertEqual(len(before), 2)
        wait(lambda: all(x != y for x, y in zip(before, b.script(PRINTS))), "the pictures to move")
        self.assertIn("stops just short of a ball", b.text("#intro"))
        self.assertIn("padr-lab run --scenario ball", b.text("#intro .made"))
        self.assertIn("tools/demo.sh --scene stop-short", b.text("#intro .live"))
        b.script("padr.connection.send({ type: 'seek', tick: 560 }); padr.connection.send({ type: 'halt' })")
        wait(lambda: (b.script("return padr.session.points.get(1)?.bodies_m ?? 0") > 5), "the ball to be far off in the picture of peer 1")
        b.picture("story")
        self.check_console(b)

    def test_every_story_is_what_its_command_plays(self):
        """Each story's confirmed worlds have the hashes of the traces that its command in the lab records."""
        with tempfile.TemporaryDirectory() as folder:
            self.open("")
            names = wait(lambda: self.browser.script("return padr.session.hello?.samples.map((s) => s.name)"), "the names of the stories")
            for name in names:
                b = self.open(f"?sample={name}")
                last = b.script("return padr.session.timeline.last")
                b.script("padr.connection.send({ type: 'halt' }); padr.connection.send({ type: 'seek', tick: arguments[0] })", last)
                self.at(last, b)
                time.sleep(0.3)  # the table follows
                told = b.script(HASHES)
                command = shlex.split(b.text("#intro .made"))
                self.assertEqual(command[0], "padr-lab")
                traces = os.path.join(folder, name)
                subprocess.run([LAB, *command[1:], "--trace", traces], cwd=TOP, check=True, capture_output=True, timeout=120)
                again = Monitor("--trace", traces)
                self.addCleanup(again.end)
                b.open(again.address)
                wait(lambda: b.script("return padr.session.timeline && padr.session.present().length"), "the traces")
                b.script("padr.connection.send({ type: 'halt' }); padr.connection.send({ type: 'seek', tick: arguments[0] })", last)
                self.at(last, b)
                wait(lambda: b.script(HASHES) == told, f"the hashes of {name}: {told}")

    def test_a_link_opens_the_same_moment(self):
        b = self.open("?sample=bad-network-fixed")
        b.script("padr.connection.send({ type: 'halt' })")
        wait(lambda: not b.script("return padr.session.timeline.playing"), "it to stand")
        b.script("padr.connection.send({ type: 'seek', tick: 742 })")
        self.at(742, b)
        b.find('figure[data-slot="2"] .large').click()
        b.find("#closer").click()
        b.script("padr.plots.select([8, 14.5])")
        b.find("#replay .share").click()
        wait(lambda: "link" in b.text("#replay .status"), "word that there is a link")
        link = b.script("return location.href")
        drawn = "padr.views.draw(); return document.querySelector('#views canvas').toDataURL()"
        other = self.start(Browser(1280, 757))
        # Somebody has moved the recording on meanwhile.
        b.script("padr.connection.send({ type: 'seek', tick: 10 })")
        self.at(10, b)
        other.open(link)
        self.at(742, other)
        self.assertEqual(other.script("return padr.views.slots()"), [2])
        self.assertEqual(other.script("return padr.plots.selected"), [8, 14.5])
        self.at(742, b)
        wait(lambda: b.script(drawn) == other.script(drawn), "the same picture, to the pixel")
        other.picture("shared")
        self.check_console(other)

    # Once, such a link ended all drawing.
    def test_a_link_with_a_wrong_zoom_shows_the_moment(self):
        for camera, zoom in (("5,5,-3", 0.5), ("5,5,0", 0.5), ("1e9,1e9,1e9", 40)):
            self.browser.driver.get("about:blank")
            b = self.open(f"?sample=stop-short#tick=300&camera={camera}")
            self.at(300, b)
            self.assertEqual(b.script("return padr.camera.zoom"), zoom)
            self.check_console(b)

    # Once, nothing was drawn after that.
    def test_a_frame_that_fails_does_not_end_the_picture(self):
        b = self.open("?sample=stop-short")
        b.script("const draw = padr.views.draw; window.drawn = 0; padr.views.draw = function () { if (window.drawn++ === 0) throw new Error('once'); draw.call(this); }")
        wait(lambda: b.script("return window.drawn") > 3, "further frames")
        b.complaints()

    def test_it_says_that_the_program_has_ended(self):
        monitor = self.start(Monitor())
        b = self.browser
        b.open(monitor.address + "?sample=stop-short")
        wait(lambda: b.script("return padr.session.timeline?.playing"), "the story to play")
        monitor.end()
        wait(lambda: "has ended, so the recording stands still" in b.text("#error"), "the page to say so")
        self.assertFalse(b.script("return padr.session.timeline.playing"))

    def test_an_unknown_story_is_named(self):
        b = self.open("?sample=nothing")
        wait(lambda: "“nothing”" in b.text("#error"), "the page to say so")
        self.check_console(b)


if __name__ == "__main__":
    main()
