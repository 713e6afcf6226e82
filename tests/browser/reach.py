#!/usr/bin/env python3
"""Who sees little, or uses no mouse, reaches everything on the page: names, order, focus, contrast in both themes. The rules
are in reach.js; the names of controls are those that Chromium itself hands to a screen reader. See browser.py."""

from browser import *
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

PEERS = 3
RULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "reach.js")
NAMED = {"button", "checkbox", "combobox", "DisclosureTriangle", "link", "searchbox", "slider", "spinbutton", "textbox", "application", "image", "table"}
OPEN_ALL = "for (const d of document.querySelectorAll('details')) d.open = true"


class Reach(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        own = [["--input", f"wander:{i}"] for i in range(PEERS)]
        cls.session = cls.start(Session(cls.monitor, PEERS, "--netem", "delay 20ms 5ms", own=own))
        cls.alone = cls.start(Monitor())

    def page(self, end="", monitor=None, **kind):
        b = Browser(1280, 757, **kind)
        self.addCleanup(b.close)
        b.open((monitor or self.monitor).address + end)
        return b

    def live(self, **kind):
        b = self.page(**kind)
        self.wait_for_peers(b, PEERS)
        b.script(OPEN_ALL)
        wait(lambda: b.script("return document.querySelectorAll('#links td').length") > 0, "the table of links")
        time.sleep(1)
        return b

    def rule(self, b, name):
        with open(RULES, encoding="utf-8") as file:
            return b.script(file.read().replace("export ", "") + f"\nreturn {name}();")

    def nameless(self, b):
        """Controls and pictures without a name, as Chromium has them."""
        b.driver.execute_cdp_cmd("Accessibility.enable", {})
        found = []
        for node in b.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]:
            role = node.get("role", {}).get("value")
            if not node.get("ignored") and role in NAMED and not node.get("name", {}).get("value", "").strip():
                found.append(f"no name: {role} {[p for p in node.get('properties', [])]}")
        return found

    def check(self, b, what):
        self.assertEqual(self.rule(b, "findings"), [], what)
        self.assertEqual(self.nameless(b), [], what)

    def test_live_in_both_themes(self):
        for dark in (False, True):
            b = self.live(dark=dark)
            self.check(b, f"live, dark: {dark}")
            b.script("padr.driver.start(0)")
            wait(lambda: "You drive" in b.text("#hint"), "driving")
            b.script("document.querySelector('[name=spec]').value = 'delay much'; document.querySelector('form.link button').click()")
            wait(lambda: "✗" in b.text(".network .status"), "a refusal")
            self.check(b, f"driving, dark: {dark}")
            b.script("padr.driver.release()")
            b.find("#tour-button").click()
            self.check(b, f"tour, dark: {dark}")
            b.find("#tour .end").click()
            wait(lambda: b.script("return document.querySelector('#tour').hidden"), "the end of the tour")

    def test_recording_and_without_peers_in_both_themes(self):
        for dark in (False, True):
            b = self.page("?sample=proxy", self.alone, dark=dark)
            wait(lambda: b.script("return padr.session.timeline && padr.session.present().length"), "the recording")
            b.script(OPEN_ALL)
            time.sleep(1)
            self.check(b, f"recording, dark: {dark}")
            b = self.page("?sample=nothing", self.alone, dark=dark)
            wait(lambda: "nothing" in b.text("#error"), "the complaint")
            self.check(b, f"without peers, dark: {dark}")

    def tab_through(self, b):
        """Presses Tab from the top on; the controls that got the focus, in order."""
        controls = self.rule(b, "controls")
        b.script("document.activeElement?.blur(); getSelection().removeAllRanges(); scrollTo(0, 0)")
        order = []
        for _ in range(len(controls) + 10):
            ActionChains(b.driver).send_keys(Keys.TAB).perform()
            now = self.rule(b, "focused")
            if now["control"] < 0 or now["control"] in order:
                break
            order.append(now["control"])
            self.assertTrue(now["seen"], f"the focus cannot be seen on {controls[now['control']]}")
        return controls, order

    def test_tab_reaches_every_control(self):
        for b in (self.live(), self.page("?sample=proxy", self.alone)):
            wait(lambda: b.script("return padr.session.present().length"), "peers")
            controls, order = self.tab_through(b)
            self.assertGreater(len(controls), 15)
            missed = [controls[i] for i in range(len(controls)) if i not in order]
            self.assertEqual(missed, [])
            self.assertEqual(order, sorted(order), "in the order of the page")

    # Once, at 200 % the tour lay over what had the focus.
    def test_the_tour_covers_no_focus(self):
        for size in ((640, 360), (1280, 757), (380, 720)):
            b = self.live()
            b.resize(*size)
            b.find("#tour-button").click()
            # What gets the focus is brought into view, as by Tab, which would be a call to the browser each time.
            covered = b.script("""const tour = document.querySelector("#tour"), found = [];
              for (const e of document.querySelectorAll("button, input, select, summary, a[href], [tabindex='0']")) {
                if (e.closest("#tour") || e.tagName === "CANVAS" || !e.checkVisibility() || e.disabled) continue;
                e.focus();
                const r = e.getBoundingClientRect();
                const over = document.elementFromPoint(r.x + Math.min(r.width, innerWidth) / 2, r.y + r.height / 2);
                if (document.activeElement === e && over && tour.contains(over)) found.push(e.outerHTML.slice(0, 80));
              }
              return found""")
            b.picture(f"reach-tour-{size[0]}")
            b.find("#tour .end").send_keys(Keys.ENTER)
            wait(lambda: b.script("return document.querySelector('#tour').hidden"), "the end of the tour")
            self.assertEqual(covered, [], size)

    def test_keys_alone_drive_and_let_go(self):
        b = self.live()
        b.script("document.querySelector('figure[data-slot=\"1\"] canvas').focus()")
        ActionChains(b.driver).send_keys(Keys.ENTER).perform()
        wait(lambda: b.script("return padr.driver.slot") == 1, "avatar 1 to be driven")
        ActionChains(b.driver).send_keys(Keys.ESCAPE).perform()
        wait(lambda: b.script("return padr.driver.slot") is None, "avatar 1 to be let go")

    def test_the_check_can_fail(self):
        b = self.live()
        b.script("""
          document.querySelector("#state").style.color = "#aaa";
          document.querySelector("main").insertAdjacentHTML("beforeend", "<h1>Another</h1><img src='icon.svg'><button tabindex='3'></button>");
          document.body.append("outside");
        """)
        found = "\n".join(self.rule(b, "findings") + self.nameless(b))
        for said in ("contrast", "2 headings of the first level", "no alternative text", "tabindex 3", "in no landmark", "no name: button"):
            self.assertIn(said, found)


if __name__ == "__main__":
    main()
