#!/usr/bin/env python3
"""The blind comparison of two ways to show corrections, taken from its beginning to the file of answers. See browser.py."""

import csv

from browser import *

RULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "reach.js")
NAMES = ("pvb", "track")
CHOICES = ["left", "right", "none", "left", "right", "none", "left", "left"]
READY = "return !document.querySelector('[data-answer=left]').disabled"


class Blind(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        cls.browser = cls.start(Browser(1280, 757))

    def open(self, seconds):
        b = self.browser
        b.open(self.monitor.address + "blind.html")
        b.script("padr.blind.seconds = arguments[0]", seconds)
        return b

    def rounds(self, b):
        """Takes all rounds; what the page said meanwhile, and where each method stood."""
        said, sides = [], []
        for number, choice in enumerate(CHOICES):
            wait(lambda: f"Round {number + 1} of 8" in b.text("#state") and b.script(READY), f"the end of round {number + 1}")
            said.append(b.script("return document.body.innerText"))
            sides.append(b.script("const { left, right, peer } = padr.blind.round; return [left, right, peer]"))
            if number == 1:
                b.find("#again").click()
                wait(lambda: b.script(READY), "the round to be shown again")
            b.find(f"[data-answer={choice}]").click()
        return said, sides

    def test_all_rounds_and_the_answers(self):
        folder = tempfile.mkdtemp()
        b = self.open(0.5)
        b.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": folder})
        said, sides = self.rounds(b)
        for text in said:
            self.assertFalse([name for name in NAMES if name in text], f"a name is shown: {text}")
        wait(lambda: "All rounds are over" in b.text("#state"), "the end")
        self.assertTrue(all(name in b.text("#result") for name in NAMES))
        self.assertEqual([left for left, _, _ in sides].count("pvb"), 4, "as often on one side as on the other")
        b.picture("blind_end")

        b.find("#answers").click()
        file = os.path.join(folder, "padr-blind.csv")
        wait(lambda: os.path.exists(file) and os.path.getsize(file) > 0, "the file")
        with open(file, encoding="utf-8") as text:
            rows = list(csv.DictReader(text))
        self.assertEqual([row["answer"] for row in rows], CHOICES)
        for row, (left, right, peer) in zip(rows, sides):
            self.assertEqual({left, right}, set(NAMES))
            self.assertEqual((row["left"], row["right"], row["peer"]), (left, right, str(peer)))
            self.assertEqual(row["chosen"], {"left": left, "right": right, "none": "none"}[row["answer"]])
            self.assertEqual(int(row["to_tick"]) - int(row["from_tick"]), 30)
        self.assertEqual([row["times_seen"] for row in rows], ["1", "2"] + ["1"] * 6)
        self.check_console(b)

    def test_both_show_the_same_moment_of_the_same_player(self):
        b = self.open(2)
        wait(lambda: b.script(READY), "the end of the first round")
        b.picture("blind")
        widths = b.script("return [...document.querySelectorAll('canvas')].map((c) => c.clientWidth)")
        self.assertEqual(len(widths), 2)
        self.assertGreater(min(widths), 450, "pictures in which a few centimetres can be seen")
        ticks, slots, to, peer = b.script("""
          const { takes, blind } = padr;
          return [takes.map((t) => t.session.timeline.tick), takes.map((t) => t.views.slots()), blind.round.to, blind.round.peer];
        """)
        for tick in ticks:
            self.assertGreaterEqual(tick, to)
            self.assertLess(tick, to + 60)
        self.assertEqual(slots, [[peer], [peer]])
        same = b.module("""
          const tick = padr.blind.round.to;
          for (const t of padr.takes) await t.connection.ask({ type: "seek", tick });
          await new Promise((done) => setTimeout(done, 500));
          const [a, b] = padr.takes.map((t) => t.session.samples.sample(padr.blind.round.peer, 0));
          const own = padr.takes[0].session.scene.bodies.length + padr.blind.round.peer;
          const off = a.world.x.map((x, i) => Math.hypot(x - b.world.x[i], a.world.y[i] - b.world.y[i]));
          return { ticks: [a.tick, b.tick], own: off[own], most: Math.max(...off) };
        """)
        self.assertEqual(same["ticks"][0], same["ticks"][1])
        self.assertIn("which looked right? Answer below", b.text("#state"))
        names = b.script("return ['left', 'right'].map((side) => document.querySelector(`#${side} canvas`).getAttribute('aria-label'))")
        self.assertEqual(names, [f"Left: View of peer {peer}.", f"Right: View of peer {peer}."])
        self.assertLess(same["own"], 1e-6, "the own avatar is shown where it is")
        self.assertLess(same["most"], 3, "the same session")
        self.check_console(b)

    # Once, it ran on in a hidden tab, and counted as seen.
    def test_what_is_played_while_nobody_sees_it_does_not_count(self):
        b = self.open(3)
        hide = "Object.defineProperty(document, 'hidden', { value: arguments[0], configurable: true }); document.dispatchEvent(new Event('visibilitychange'))"
        tick = "return padr.takes.map((t) => t.session.timeline.tick - padr.blind.round.from)"
        standing = "return padr.takes.every((t) => !t.session.timeline.playing)"
        wait(lambda: b.script("return padr.blind.round !== undefined") and min(b.script(tick)) > 30 and not b.script(standing), "it to play")
        b.script(hide, True)
        wait(lambda: b.script(standing), "it to halt")
        self.assertFalse(b.script(READY))
        b.script(hide, False)
        wait(lambda: max(b.script(tick)) < 30, "it to begin anew")
        wait(lambda: b.script(READY), "the end of the round")
        self.assertEqual(b.script("return padr.blind.round.seen"), 1)
        b.script(hide, True)
        self.assertTrue(b.script(READY), "what has been seen has been seen")
        b.script(hide, False)
        self.check_console(b)

    # Once, each answer left the keyboard's focus nowhere.
    def test_it_is_taken_by_keyboard(self):
        b = self.open(0.3)
        self.assertEqual(b.find("#state").get_attribute("role"), "status")
        focus = "return document.activeElement.dataset.answer ?? document.activeElement.id"
        wait(lambda: b.script(READY), "the end of the first round")
        b.find("[data-answer=none]").send_keys("\n")
        for number in range(2, 9):
            wait(lambda: f"Round {number}" in b.text("#state") and b.script(READY), f"the end of round {number}")
            self.assertEqual(b.script(focus), "left")
            b.driver.switch_to.active_element.send_keys("\n")
        wait(lambda: "All rounds are over" in b.text("#state"), "the end")
        self.assertEqual(b.script(focus), "answers")

    def test_it_can_be_reached_and_read(self):
        b = self.open(0.5)
        wait(lambda: b.script(READY), "the end of the first round")
        with open(RULES, encoding="utf-8") as file:
            self.assertEqual(b.script(file.read().replace("export ", "") + "\nreturn findings();"), [])


if __name__ == "__main__":
    main()
