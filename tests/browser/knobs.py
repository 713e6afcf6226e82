#!/usr/bin/env python3
"""Knobs that are turned on the page change what peers do. See browser.py."""

from browser import *
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

PEERS = 3


class Knobs(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        own = [["--input", f"wander:{i}"] for i in range(PEERS)]
        cls.session = cls.start(Session(cls.monitor, PEERS, "--netem", "delay 10ms", own=own))
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def setUp(self):
        self.wait_for_peers(self.browser, PEERS)

    def tearDown(self):
        self.check_console(self.browser)

    def choose(self, name, value):
        Select(self.browser.find(f'[name="{name}"]')).select_by_value(str(value))

    def status(self, where):
        return wait(lambda: self.browser.text(f".{where} .status"), f"an answer about {where}")

    def type_over(self, box, text):
        """At once: the page puts back what holds where nobody is at a box, and on a busy machine a second call comes later."""
        box.send_keys(Keys.CONTROL, "a", Keys.NULL, text, Keys.ENTER)

    def test_a_network_is_felt(self):
        b = self.browser
        delays = "return padr.session.present().flatMap((p) => p.links.map((l) => l.delay_ms))"
        wait(lambda: len(b.script(delays)) == PEERS * (PEERS - 1) and all(d is not None and d < 60 for d in b.script(delays)), "short delays")
        self.choose("network", "delay 250ms 100ms loss 20%")
        self.assertIn("✓", self.status("network"))
        spec = "return document.querySelector('[name=spec]').value"
        self.assertEqual(b.script(spec), "delay 250ms 100ms loss 20%")
        wait(lambda: all(d > 120 for d in b.script(delays)), "long delays")
        wait(lambda: b.script("return padr.events.list.filter((e) => e.kind === 'netem').length") >= PEERS, "events that say so")
        box = b.find('[name="spec"]')
        self.type_over(box, "delay 5ms")
        wait(lambda: "delay 5ms" in b.text(".network .status"), "an answer about the short delay")
        wait(lambda: all(d < 60 for d in b.script(delays)), "short delays again")

    def test_a_wrong_network_is_refused_in_its_place(self):
        b = self.browser
        box = b.find('[name="spec"]')
        self.type_over(box, "delay much")
        wait(lambda: "✗" in b.text(".network .status") and "much" in b.text(".network .status"), "what is wrong, in words")
        b.picture("refused")
        self.assertTrue(b.script("return document.querySelector('.network .status').classList.contains('error')"))
        # Once, the field had what holds again, and the message named a word that was nowhere.
        b.script("document.activeElement.blur()")
        time.sleep(2.5)
        self.assertEqual(b.script("return document.querySelector('[name=spec]').value"), "delay much")
        self.type_over(box, "delay 10ms")
        wait(lambda: "✓ delay 10ms" in b.text(".network .status"), "what is right to be taken")

    # Once, only the command line warned.
    def test_a_doubtful_network_is_warned_of(self):
        b = self.browser
        self.type_over(b.find('[name="spec"]'), "delay 10")
        wait(lambda: "✓ delay 10. Warning:" in b.text(".network .status") and "microseconds" in b.text(".network .status"), "a warning")
        self.type_over(b.find('[name="spec"]'), "delay 10ms")
        wait(lambda: b.text(".network .status") == "✓ delay 10ms", "no warning")

    # Once, each step gave the focus to the driven picture.
    def test_keys_turn_a_knob_on_while_driving(self):
        b = self.browser
        b.script("padr.driver.start(0)")
        self.addCleanup(b.script, "padr.driver.release()")
        wait(lambda: "You drive" in b.text("#hint"), "driving")
        wait(lambda: b.script("return padr.session.controllable().length") == PEERS, "knobs")
        slider = b.find('[name="body"]')
        slider.send_keys(Keys.END)
        for _ in range(3):
            b.driver.switch_to.active_element.send_keys(Keys.ARROW_LEFT)
        self.assertEqual(b.script("return document.activeElement.name"), "body")
        wait(lambda: b.script("return padr.session.present().every((p) => p.knobs['body-threshold'] === '0.485')"), "three steps")
        # By mouse the keys steer again.
        b.find('[name="replay"]').click()
        self.assertEqual(b.script("return document.activeElement.tagName"), "CANVAS")
        b.find('[name="replay"]').click()

    # Once, the list showed the technique, and to choose it again did nothing.
    def test_the_settings_of_a_technique_come_back(self):
        b = self.browser
        self.choose("technique", "adaptive")
        b.script("document.querySelector('.technique details').open = true")
        self.choose("other", "threshold")
        self.type_over(b.find('[name="value"]'), "0.77")
        every = "return padr.session.present().every((p) => p.technique === 'adaptive' && p.knobs.threshold === arguments[0])"
        wait(lambda: b.script(every, "0.77"), "another threshold")
        b.find("button.afresh").click()
        wait(lambda: b.script("return padr.session.present().every((p) => p.knobs.threshold !== '0.77')"), "the technique's own")
        self.choose("technique", "full")
        wait(lambda: b.script("return padr.session.present().every((p) => p.technique === 'full')"), "full again")

    def test_a_threshold_comes_into_force(self):
        b = self.browser
        slide = """const [name, value] = arguments, i = document.querySelector(`[name=${name}]`); i.value = value;
          for (const kind of ["input", "change"]) i.dispatchEvent(new Event(kind, { bubbles: true }));"""
        self.choose("peer", 1)
        b.script(slide, "high", 1.7)
        b.script(slide, "low", 1.7)
        threshold = "const s = padr.session.samples.sample(arguments[0], 0); return s ? s.threshold : 0"
        wait(lambda: abs(b.script(threshold, 1) - 1.7) < 0.01, "the threshold of peer 1")
        self.assertLess(b.script(threshold, 0), 1.0)
        self.choose("peer", "all")
        b.script(slide, "high", 0.2)
        wait(lambda: all(b.script(threshold, p) < 0.21 for p in range(PEERS)), "the threshold of all")

    # Once, it then showed the first technique of the list, and the thresholds that the page begins with.
    def test_where_peers_differ_nothing_is_shown_that_nobody_has(self):
        b = self.browser
        self.choose("peer", 1)
        self.choose("technique", "fixed")
        techniques = "return padr.session.present().map((p) => p.technique)"
        wait(lambda: sorted(set(b.script(techniques))) == ["fixed", "full"], "one to play otherwise")
        self.choose("peer", "all")
        chosen = "return [...document.querySelectorAll('[name=technique], [name=model], [name=network]')].map((l) => l.selectedOptions[0].text)"
        wait(lambda: b.script(chosen) == ["as written below", "differ", "differ"], "lists that say so")
        beside = "return [...document.querySelectorAll('[name=high], [name=low], [name=body]')].map((i) => i.nextElementSibling.textContent)"
        wait(lambda: b.script(beside) == ["differ"] * 3, "thresholds that differ")
        b.picture("they-differ")
        self.choose("technique", "full")
        wait(lambda: b.script(techniques) == ["full"] * PEERS, "all to be full")
        wait(lambda: "differ" not in b.script(beside), "the thresholds of all")
        wait(lambda: b.script("return document.querySelectorAll('#knobs option[value=differ]').length") == 0, "the lists of all")

    def test_a_technique_for_all(self):
        b = self.browser
        for name in ("adaptive", "full"):
            self.choose("technique", name)
            wait(lambda: b.script("return padr.session.present().map((p) => p.technique)") == [name] * PEERS, f"all to be {name}")
        # All have to agree on authority when they begin: it cannot change.
        self.assertTrue(b.script("return [...document.querySelectorAll('[name=technique] option')].find((o) => o.value === 'avatar-only').disabled"))

    def test_any_knob_and_a_wrong_value(self):
        b = self.browser
        b.script("document.querySelector('.technique details').open = true")
        self.choose("other", "pcc-bound")
        value = b.find('[name="value"]')
        value.send_keys("0.25", Keys.ENTER)
        wait(lambda: b.script("return padr.session.present().every((p) => p.knobs['pcc-bound'] === '0.25')"), "the bound of all")
        self.type_over(value, "-3")
        wait(lambda: "✗" in b.text(".technique .status") and "-3" in b.text(".technique .status"), "a refusal")

    def test_pausing_and_going_on(self):
        b = self.browser
        # Once, only tooltips said whom it stops, and only an event that it ends by itself.
        self.assertEqual(b.text("button.pause"), "Pause all")
        self.choose("peer", 2)
        self.assertEqual(b.text("button.pause"), "Pause peer 2")
        b.find("button.pause").click()
        wait(lambda: "paused, for 600 s at most" in b.text(".actions .status"), "for how long")
        wait(lambda: b.script("return padr.session.peer(2).paused"), "peer 2 to stand")
        wait(lambda: "paused" in b.text('figure[data-slot="2"] .said'), "its picture to say so")
        b.picture("paused")
        b.find("button.resume").click()
        wait(lambda: b.script("return padr.session.present().every((p) => !p.paused)"), "all to go on")
        self.choose("peer", "all")
        wait(lambda: b.script("return padr.session.present().length") == PEERS, "all to be there")

    def test_throwing_a_body(self):
        b = self.browser
        b.find("button.throw").click()
        self.assertIn("✓", self.status("actions"))
        wait(lambda: b.script("return padr.events.list.some((e) => e.kind === 'push')"), "an event that says so")

    def test_z_a_cut_heals(self):
        b = self.browser
        seen = "(padr.session.samples.sample(0, 0).world.flags[padr.session.scene.bodies.length + 2] & 1) === 1"
        cut = b.from_now_on("padr.session.peer(2).links.some((l) => l.cut)")
        told = b.from_now_on("document.querySelector('#links').textContent.includes('✂')")
        gone = b.from_now_on(f"!({seen})")
        self.choose("cutPeer", 2)
        b.find("button.cut").click()
        wait(cut, "the links to be cut")
        wait(told, "the table to say so")
        b.picture("cut")
        # For the others its avatar is gone after three seconds, and then there again.
        wait(gone, "peer 2 to be given up")
        wait(lambda: b.script(f"return {seen}"), "peer 2 to be back", 60)
        state = "const p = padr.session.peer(2); return p.state === 'here' && !p.links.some((l) => l.cut) && p.confirmed.state"
        wait(lambda: b.script(state) == "identical", "its world to be the others'")
        b.picture("healed")


if __name__ == "__main__":
    main()
