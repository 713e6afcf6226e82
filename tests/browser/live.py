#!/usr/bin/env python3
"""A live session on the page: views that move, an avatar that is driven, plots, tables, small screens. See browser.py."""

from urllib.request import urlopen

from browser import *
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

PEERS = 4
NETEM = "delay 60ms 10ms loss 2%"

# When the avatar `given[0]` has moved by 10 cm to the right in each view, in ms since now.
WATCH = """
  const [slot] = given;
  const s = padr.session;
  const id = s.scene.bodies.length + slot;
  const newest = (view) => s.samples.rings.get(view * 8).frames.at(-1).world.x[id];
  const slots = s.present().map((p) => p.slot);
  const start = slots.map(newest);
  const moved = slots.map(() => null);
  window.moved = moved;
  const began = performance.now();
  const timer = setInterval(() => {
    slots.forEach((view, i) => { if (moved[i] === null && newest(view) > start[i] + 0.1) moved[i] = performance.now() - began; });
    if (moved.every((m) => m !== null)) clearInterval(timer);
  }, 4);
"""

PRINTS = "return [...document.querySelectorAll('#views canvas')].map((c) => c.toDataURL())"


class Live(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        # The avatar that is driven rests otherwise, so that only keys move it.
        own = [["--input", "rest"]] + [["--input", f"wander:{i}"] for i in range(1, PEERS)]
        cls.session = cls.start(Session(cls.monitor, PEERS, "--netem", NETEM, own=own))
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def setUp(self):
        self.wait_for_peers(self.browser, PEERS)

    def tearDown(self):
        self.browser.script("padr.driver.release()")

    def test_views_move_and_worlds_are_identical(self):
        b = self.browser
        self.assertEqual(b.script("return document.querySelectorAll('#views canvas').length"), PEERS)
        before = b.script(PRINTS)
        wait(lambda: all(x != y for x, y in zip(before, b.script(PRINTS))), "every canvas to change")
        cells = "return [...document.querySelectorAll('#peers td[data-verdict]')].map((c) => c.textContent)"
        wait(lambda: [c[:11] for c in b.script(cells)] == ["✓ identical"] * PEERS, "all hashes to be identical")
        self.assertIn("identical", b.text("#verdict"))
        green = b.script("return getComputedStyle(document.querySelector('#peers td[data-verdict]')).color")
        self.assertEqual(green, b.script("return getComputedStyle(document.querySelector('#verdict')).color"))
        time.sleep(2)
        b.picture("live")
        self.check_console(b)

    def test_d_moves_the_avatar_in_all_views(self):
        b = self.browser
        b.find('figure[data-slot="0"] canvas').click()
        wait(lambda: b.script("return padr.session.peer(0).driven") == "you", "the peer to be driven")
        self.assertIn("You drive avatar 0", b.text("#hint"))
        self.assertIn("driven", b.find('figure[data-slot="0"]').get_attribute("class"))
        time.sleep(0.5)
        b.module(WATCH, 0)
        ActionChains(b.driver).key_down("d").perform()
        try:
            moved = wait(lambda: all(b.script("return window.moved")) and b.script("return window.moved"), "avatar 0 to move in all views")
            b.picture("driven")
        finally:
            ActionChains(b.driver).key_up("d").perform()
        print(f"avatar 0 had moved after {moved[0]:.0f} ms in its own view, after {[round(m) for m in moved[1:]]} ms in the others")
        # The links take 60 ms +- 10 ms and lose 2 %; frames come 20 times a second; a threshold has to be exceeded.
        for there in moved[1:]:
            self.assertLess(there - moved[0], 1000)
        # Escape lets go, and what was driven can be saved.
        ActionChains(b.driver).send_keys(Keys.ESCAPE).perform()
        wait(lambda: b.script("return padr.session.peer(0).driven") == "no", "the peer to be let go")
        link = b.script("const a = document.querySelector('#save'); return a.hidden ? '' : a.href")
        with urlopen(link) as answer:
            rows = answer.read().decode().split()
        self.assertRegex(rows[1], r"^[\d.]+,-?[\d.]+,-?[\d.]+$")
        self.assertGreater(len(rows), 10)
        self.check_console(b)

    def test_the_pointer_leads_the_avatar(self):
        b = self.browser
        b.find('figure[data-slot="0"] .drive').click()
        wait(lambda: b.script("return padr.session.peer(0).driven") == "you", "the peer to be driven")
        where = "const s = padr.session, w = s.samples.sample(0, 0).world, i = s.scene.bodies.length; return [w.x[i], w.y[i]]"
        canvas = b.find('figure[data-slot="0"] canvas')
        x, y = b.script(where)
        goal = [10, 7.5]  # the middle
        actions = ActionChains(b.driver).move_to_element(canvas).click_and_hold()
        actions.perform()
        try:
            far = ((x - goal[0]) ** 2 + (y - goal[1]) ** 2) ** 0.5
            wait(lambda: sum((p - q) ** 2 for p, q in zip(b.script(where), goal)) ** 0.5 < max(1.0, far / 2), "the avatar to come")
        finally:
            ActionChains(b.driver).release().perform()
        self.assertEqual(b.script("return padr.driver.target"), None)

    def test_a_gamepad_drives(self):
        b = self.browser
        # The Gamepad API as a stick pushed to the right would have it; there is none here.
        b.script("navigator.getGamepads = () => [null, { connected: true, axes: [0.9, 0.1], buttons: [] }]")
        self.addCleanup(b.script, "delete navigator.getGamepads")
        b.script("padr.driver.start(0)")
        wait(lambda: b.script("return padr.session.peer(0).driven") == "you", "the peer to be driven")
        self.assertEqual(b.script("return padr.driver.direction()"), [0.9, -0.1])
        b.script("padr.driver.held.add('KeyA')")  # keys come before the stick
        self.assertEqual(b.script("return padr.driver.direction()"), [-1, 0])

    def test_plots_fill_and_are_read_together(self):
        b = self.browser
        b.script("document.querySelector('#plots').scrollIntoView()")
        rows = "return padr.plots.charts.map((c) => c.graph ? c.graph.numRows() : 0)"
        wait(lambda: min(b.script(rows)) > 20, "rows in all plots")
        values = "return padr.plots.charts.map((c) => c.rows.at(-1).slice(1).filter((v) => v !== null).length)"
        wait(lambda: min(b.script(values)) > 0, "values in all plots")
        wait(lambda: b.script("return padr.events.list.length") > 0, "events")
        time.sleep(1)
        b.picture("plots")
        chart = b.find("#plots .chart")
        ActionChains(b.driver).move_to_element_with_offset(chart, 60, 0).perform()
        times = "return [...document.querySelectorAll('#plots .values b')].map((e) => e.textContent.split(' ')[0])"
        self.assertEqual(len(set(b.script(times))), 1)
        b.picture("plots-hover")
        # Dragging across one zooms all.
        ActionChains(b.driver).move_to_element_with_offset(chart, -60, 0).click_and_hold().move_by_offset(150, 0).release().perform()
        windows = "return padr.plots.charts.map((c) => c.graph.xAxisRange())"
        wait(lambda: b.script("return padr.plots.selected"), "a selected span")
        selected = b.script("return padr.plots.selected")
        self.assertEqual(b.script(windows), [selected] * 4)
        ActionChains(b.driver).double_click(chart).perform()
        wait(lambda: b.script("return padr.plots.selected") is None, "the newest minute again")
        b.script("scrollTo(0, 0)")
        self.check_console(b)

    def test_overlaid_and_one_alone_and_ghosts(self):
        b = self.browser
        b.find('button[data-mode="overlay"]').click()
        wait(lambda: b.script("return document.querySelectorAll('#views canvas').length") == 1, "one canvas")
        boxes = "return ['authority', 'predicted', 'confirmed'].map((name) => document.querySelector(`#ghost-${name}`).disabled)"
        self.assertEqual(b.script(boxes), [True] * 3)  # once, they could be set, and did nothing
        self.assertIsNone(b.find("body").get_attribute("aria-pressed"))
        time.sleep(1)
        b.picture("overlaid")
        b.find('button[data-mode="side"]').click()
        self.assertEqual(b.script(boxes), [False] * 3)
        for name in ("predicted", "confirmed"):
            b.find(f"#ghost-{name}").click()
        b.find('figure[data-slot="1"] .large').click()
        wait(lambda: b.script("return padr.session.samples.sample(1, 2) && padr.session.samples.sample(1, 3) && true"), "ghosts")
        b.find('figure[data-slot="1"] .follow').click()
        wait(lambda: b.script("""const s = padr.session, w = s.samples.sample(1, 0).world;
          return Math.abs(padr.camera.x - w.x[s.scene.bodies.length + 1]) < 0.01"""), "the camera to follow")
        time.sleep(1)
        b.picture("one-ghosts")
        b.find("#reset").click()
        b.find('figure[data-slot="1"] .large').click()
        for name in ("predicted", "confirmed"):
            b.find(f"#ghost-{name}").click()
        wait(lambda: b.script("return document.querySelectorAll('#views canvas').length") == PEERS, "all again")
        self.check_console(b)

    def test_on_a_phone_and_in_the_dark(self):
        phone = Browser(360, 740, dark=True, phone=True)
        self.addCleanup(phone.close)
        phone.open(self.monitor.address)
        self.wait_for_peers(phone, PEERS)
        self.assertEqual(phone.script("return document.documentElement.scrollWidth"), 360)
        self.assertEqual(phone.script("return document.documentElement.dataset.theme"), "dark")
        darkness = phone.script("return getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)")
        self.assertLess(max(darkness), 60)
        phone.script("document.querySelector('#plots').scrollIntoView()")
        wait(lambda: min(phone.script("return padr.plots.charts.map((c) => c.graph ? c.graph.numRows() : 0)")) > 10, "plots")
        # Once, it told of dragging and double-clicking.
        self.assertTrue(phone.script("return document.querySelector('#plots-part .note').innerText").startswith("Marks:"))
        phone.script("scrollTo(0, 0)")
        time.sleep(1)
        phone.picture("phone", whole=True)
        phone.find("#theme").click()
        self.assertEqual(phone.script("return document.documentElement.dataset.theme"), "light")
        self.check_console(phone)

    def test_two_browsers_drive_two_avatars_and_one_takes_over(self):
        other = Browser()
        self.addCleanup(other.close)
        other.open(self.monitor.address)
        self.wait_for_peers(other, PEERS)
        self.browser.script("padr.driver.start(0)")
        other.script("padr.driver.start(1)")
        wait(lambda: other.script("return padr.session.peer(0).driven + padr.session.peer(1).driven") == "otheryou", "both to drive")
        other.script("padr.driver.start(0)")
        wait(lambda: self.browser.script("return padr.driver.slot") is None, "the first to lose it")
        self.assertIn("Somebody else", self.browser.text("#hint"))

    # Once, a tab that was shown again took the avatar back from whoever drove it by then.
    def test_a_tab_that_was_hidden_drives_no_more(self):
        b = self.browser
        b.script("padr.driver.start(0)")
        wait(lambda: b.script("return padr.session.peer(0).driven") == "you", "the peer to be driven")
        first = b.driver.current_window_handle
        b.driver.switch_to.new_window("tab")
        other = b.driver.current_window_handle
        b.open(self.monitor.address)
        self.wait_for_peers(b, PEERS)
        wait(lambda: b.script("return padr.session.peer(0).driven") == "no", "the order to lapse")
        b.script("padr.driver.start(0)")
        wait(lambda: b.script("return padr.session.peer(0).driven") == "you", "the other tab to drive")
        b.driver.switch_to.window(first)
        b.driver.execute_cdp_cmd("Page.bringToFront", {})
        self.assertEqual(b.script("return document.visibilityState"), "visible")
        wait(lambda: b.script("return padr.driver.slot") is None, "the first to know")
        self.assertIn("Avatar 0 was let go", b.text("#hint"))
        b.driver.switch_to.window(other)
        b.driver.close()
        b.driver.switch_to.window(first)

    def test_zz_the_page_survives_the_monitor(self):
        b = self.browser
        listen = self.monitor.address.split("/")[2]
        self.monitor.end(signal.SIGKILL)
        wait(lambda: "lost" in b.text("#error"), "the page to say so")
        b.picture("lost")
        b.complaints()
        again = self.start(Monitor(listen=listen, peers=self.monitor.peers))
        self.assertIsNotNone(again)
        wait(lambda: b.script("return document.querySelector('#error').hidden"), "the page to connect")
        self.wait_for_peers(b, PEERS)
        before = b.script(PRINTS)
        wait(lambda: all(x != y for x, y in zip(before, b.script(PRINTS))), "every canvas to change")


if __name__ == "__main__":
    main()
