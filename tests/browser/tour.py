#!/usr/bin/env python3
"""The guided tour, as somebody new would take it: it sets the knobs, and restores them at its end. See browser.py."""

from browser import *
from selenium.webdriver.common.keys import Keys

PEERS = 4
STEPS = 9
TOO_WIDE = """return [...document.querySelectorAll('#plots .chart')].map((box) => [box.clientWidth, box.querySelector('canvas')?.clientWidth])
  .filter(([box, canvas]) => Math.abs(box - canvas) > 1)"""
HOW = """return padr.session.controllable().map((p) => [p.slot, p.technique, p.knobs, p.links.map((l) => [l.to, l.netem ?? ""])])"""


class Tour(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        own = [["--input", f"wander:{i}"] for i in range(PEERS)]
        cls.session = cls.start(Session(cls.monitor, PEERS, "--netem", "delay 100ms 50ms loss 10%", "--threshold", "0.7:0.2", own=own))
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def test_all_steps_and_everything_as_before(self):
        b = self.browser
        self.wait_for_peers(b, PEERS)
        wait(lambda: all(len(p[3]) == PEERS - 1 and p[2] for p in b.script(HOW)), "all links and knobs to be told")
        before = b.script(HOW)
        b.find("#tour-button").click()
        inconsistency = "return [...padr.session.points.values()].reduce((a, p) => a + (p.combined_m ?? 0), 0)"
        for step in range(1, STEPS + 1):
            self.assertEqual(b.text("#tour .count"), f"Step {step} of {STEPS}")
            time.sleep(3.5)
            b.picture(f"tour-{step}")
            print(f"{b.text('#tour .title')}: combined inconsistency of all views {b.script(inconsistency):.2f} m")
            self.assertEqual(b.text("#tour .status"), "")
            if step == 2:
                cut = b.from_now_on("padr.session.present().every((p) => p.links.some((l) => l.cut))")
                b.find("#tour .again").click()
                wait(cut, "the links to be cut")
                wait(lambda: b.script("return padr.session.present().every((p) => p.links.every((l) => !l.cut))"), "the links to heal")
            if not b.script("return document.querySelector('#tour .half').hidden"):
                b.find("#tour .half").click()
                time.sleep(3.5)
                b.picture(f"tour-{step}b")
                print(f"  the other half: {b.script(inconsistency):.2f} m")
            if step == STEPS:  # the one who was cut off has to be back
                wait(lambda: b.script("return padr.session.present().every((p) => p.state === 'here' && p.links.every((l) => !l.cut))"), "the cut to heal")
                self.wait_for_peers(b, PEERS)
            b.find("#tour .next" if step < STEPS else "#tour .end").click()
        self.assertTrue(b.script("return document.querySelector('#tour').hidden"))
        wait(lambda: same(b.script(HOW), before), f"everything as before: {before}")
        b.script("document.querySelector('#plots').scrollIntoView()")
        wait(lambda: b.script(TOO_WIDE) == [], "every plot to fit its card")
        b.picture("tour-after")
        self.check_console(b)

    # Once, nothing was restored then: all kept the settings of the step.
    def test_goes_on_after_the_page_was_loaded_again(self):
        b = self.browser
        self.wait_for_peers(b, PEERS)
        wait(lambda: all(len(p[3]) == PEERS - 1 and p[2] for p in b.script(HOW)), "all links and knobs to be told")
        before = b.script(HOW)
        b.find("#tour-button").click()
        b.find("#tour .next").click()
        wait(lambda: b.script("return padr.session.present().every((p) => p.technique === 'fixed')"), "the settings of the step")
        b.open(self.monitor.address)
        self.wait_for_peers(b, PEERS)
        wait(lambda: b.text("#tour .count") == f"Step 2 of {STEPS}", "the same step")
        self.assertFalse(b.script("return document.querySelector('#tour').hidden"))
        b.find("#tour .end").click()
        wait(lambda: same(b.script(HOW), before), f"everything as before: {before}")
        b.open(self.monitor.address)
        self.wait_for_peers(b, PEERS)
        time.sleep(1)
        self.assertTrue(b.script("return document.querySelector('#tour').hidden"), "it has ended")


class Scene(Case):
    """The tour in the session that tools/demo.sh --scene stop-short plays."""

    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        path = os.path.join(os.path.dirname(__file__), "../../common/scenarios/paths/ball.csv")
        cls.session = cls.start(Session(cls.monitor, 2, "--scenario", "ball", "--technique", "avatar-only", "--threshold", "0.8",
                                        own=[["--input", f"path:{path},loop"], ["--input", "rest"]]))  # fmt: skip
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def test_says_what_is_seen_without_authority(self):
        b = self.browser
        self.wait_for_peers(b, 2)
        wait(lambda: b.script("return (padr.session.points.get(1)?.bodies_m ?? 0) > 1"), "the model to have hit the ball")
        b.find("#tour-button").click()
        said = {}
        for step in range(1, STEPS + 1):
            said[b.text("#tour .title")] = b.text("#tour .text")
            time.sleep(0.3)
            self.assertEqual(b.text("#tour .status"), "", "no step asks for what a session without authority refuses")
            b.find("#tour .next" if step < STEPS else "#tour .end").click()
        self.assertIn("Time after time avatar 0 runs at the ball. It stops just short", said["Stopping short"])
        self.assertIn("Nobody has authority here", said["Stopping short"])
        self.assertIn("look-ahead is blind to a stop short", said["What a predictor sees"])
        self.assertIn("the story “Collision by proxy”", said["The chain by proxy"])
        self.check_console(b)

    # Once, the tour vanished without a word, and left the settings of its step.
    def test_goes_on_after_the_connection_was_lost(self):
        b = self.browser
        self.wait_for_peers(b, 2)
        b.find("#tour-button").click()
        b.find("#tour .next").click()
        b.script("padr.session.takePeers({ peers: [] }); padr.connection.socket.close()")
        self.wait_for_peers(b, 2)
        self.assertEqual(b.text("#tour .count"), f"Step 2 of {STEPS}")
        self.assertFalse(b.script("return document.querySelector('#tour').hidden"))
        b.find("#tour .end").click()
        wait(lambda: b.script("return document.querySelector('#tour').hidden"), "the end of the tour")

    # Once, the button that ends the tour came in the place of "Next" then, and who was fast had pressed it.
    def test_next_never_ends_it(self):
        b = self.browser
        self.wait_for_peers(b, 2)
        b.find("#tour-button").click()
        b.script("for (let i = 0; i < 20; ++i) document.querySelector('#tour .next').click()")
        self.assertEqual(b.text("#tour .count"), f"Step {STEPS} of {STEPS}")
        b.script("document.querySelector('#tour .back').click()")
        b.find("#tour .next").send_keys(Keys.ENTER)
        self.assertEqual(b.text("#tour .count"), f"Step {STEPS} of {STEPS}")
        self.assertEqual(b.text("#tour .end"), "End, and restore (Esc)")
        b.script("return document.activeElement").send_keys(Keys.ESCAPE)  # there is a focus
        wait(lambda: b.script("return document.querySelector('#tour').hidden"), "the end of the tour")

    # Once, the focus was nowhere afterwards, and steps changed without a word to a screen reader.
    def test_escape_ends_it_and_the_focus_goes_back(self):
        b = self.browser
        self.wait_for_peers(b, 2)
        b.find("#tour-button").click()
        said = b.script("return document.querySelector('#tour .text').closest('[aria-live=polite]')?.textContent")
        self.assertIn("Step 1 of", said)
        b.find("#tour .next").send_keys(Keys.ESCAPE)
        wait(lambda: b.script("return document.querySelector('#tour').hidden"), "the end of the tour")
        self.assertEqual(b.script("return document.activeElement.id"), "tour-button")

    def test_the_end_of_the_session_ends_the_tour(self):
        b = self.browser
        self.wait_for_peers(b, 2)
        b.find("#tour-button").click()
        for peer in self.session.peers:
            peer.end(signal.SIGINT)
        wait(lambda: b.script("return document.querySelector('#tour').hidden"), "the tour to end")
        wait(lambda: "The session is over." in b.text("#empty"), "word that the session is over")
        self.monitor.end()
        wait(lambda: "The session is over." in b.text("#error"), "the same word without padr-monitor")
        self.assertNotIn("undefined", b.script("return document.body.innerText"))
        b.picture("session-over")


def same(now, before):
    """Technique and knobs as before; links as far as they are there."""
    return all(n[:3] == o[:3] and all(link in o[3] for link in n[3]) for n, o in zip(now, before)) and len(now) == len(before)


if __name__ == "__main__":
    main()
