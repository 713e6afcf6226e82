#!/usr/bin/env python3
"""What somebody sees first, on a small laptop and on a phone: nothing is cut off, and what is spoken of is in view. See browser.py."""

from browser import *

PEERS = 3
STEPS = 9

# Texts that do not fit where they stand, and choices that are wider than their list.
CUT_OFF = """
  const seen = (e) => e.getClientRects().length > 0 && !e.closest(".scroll, .unseen");
  const texts = [...document.querySelectorAll("h1, h2, h3, legend, label, button, summary, figcaption strong, p")]
    .filter((e) => seen(e) && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline").map((e) => e.textContent.trim());
  const pen = document.createElement("canvas").getContext("2d");
  const lists = [...document.querySelectorAll("select")].filter(seen).filter((list) => {
    const style = getComputedStyle(list);
    pen.font = style.font;
    const room = list.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight) - 18; // the arrow
    return [...list.options].some((o) => pen.measureText(o.text).width > room);
  }).map((list) => list.name);
  const wide = document.documentElement.scrollWidth > innerWidth ? ["the page itself"] : [];
  return [...texts, ...lists, ...wide];
"""

# Which of these cannot be seen whole without scrolling.
OUT_OF_VIEW = """
  return arguments[0].filter((selector) => {
    const box = document.querySelector(selector).getBoundingClientRect();
    return box.height === 0 || box.top < 0 || box.bottom > innerHeight + 1;
  });
"""
SPOTS = {"plots": "#plots figure:first-child", "table": "#peers", "events": "#events", "": "#views"}
SENTENCES = "return document.querySelector('#intro .text').textContent.split(/[.] /).length"


class Look(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        own = [["--input", f"wander:{i}"] for i in range(PEERS)]
        cls.session = cls.start(Session(cls.monitor, PEERS, "--netem", "delay 20ms 5ms", own=own))

    def page(self, *size, **kind):
        b = Browser(*size, **kind)
        self.addCleanup(b.close)
        b.open(self.monitor.address)
        self.wait_for_peers(b, PEERS)
        return b

    def wait_in_view(self, b, spots, what):
        where = "return arguments[0].map((s) => { const box = document.querySelector(s).getBoundingClientRect(); return [s, box.top, box.bottom]; })"
        wait(lambda: not b.script(OUT_OF_VIEW, spots), lambda: f"{what} to be in view; out of it {b.script(OUT_OF_VIEW, spots)} of {b.script(where, spots)}")

    def take_tour(self, b, look):
        b.find("#tour-button").click()
        for step in range(1, STEPS + 1):
            time.sleep(0.5)
            look(step)
            b.find("#tour .next" if step < STEPS else "#tour .end").click()
        wait(lambda: b.script("return padr.session.present().every((p) => p.state === 'here' && p.links.every((l) => !l.cut))"), "the cut to heal")
        self.wait_for_peers(b, PEERS)

    def test_small_laptop(self):
        b = self.page(1280, 757)
        self.assertEqual(b.script(CUT_OFF), [])
        self.assertEqual(b.script(OUT_OF_VIEW, ["header", "#intro", "#views", "#knobs > div"]), [])
        self.assertIn("Three programs play", b.text("#intro"))
        self.assertIn("WASD", b.text("#intro"))
        self.assertEqual(b.script(SENTENCES), 3)
        b.picture("look-laptop")

        def look(step):
            spot = b.script("return padr.tour.spot()")
            self.wait_in_view(b, ["#tour", "#views", SPOTS[spot]], f"step {step}")
            self.assertEqual(b.script(CUT_OFF), [], f"step {step}")
            if step == 4:
                self.assertIn("1.5 m for peers 0 and 2 now, and 0.1 m for peer 1", b.text("#tour .text"))
            b.picture(f"look-tour-{step}")

        self.take_tour(b, look)
        self.check_console(b)

    # Once, at the end of the page they lay over the tables.
    def test_knobs_cover_no_table(self):
        for size in ((1280, 800), (1920, 1080)):
            b = self.page(*size)
            b.script("for (const d of document.querySelectorAll('details')) d.open = true; scrollTo(0, document.body.scrollHeight)")
            edges = """const box = (s) => document.querySelector(s).getBoundingClientRect();
              return [box('#knobs > div').bottom, box('#table-part').top]"""
            knobs, table = b.script(edges)
            self.assertLessEqual(knobs, table, size)
            # They stay in view on the way there.
            b.script("scrollTo(0, 400)")
            self.assertEqual(b.script("return document.querySelector('#knobs > div').getBoundingClientRect().top"), 8)
            b.picture(f"look-knobs-{size[0]}")

    # Once, the line that says how to drive pushed the picture down, away from the pointer.
    def test_a_picture_that_is_clicked_stays_where_it_is(self):
        b = self.page(1280, 800)
        box = "const { x, y, width, height } = document.querySelector('figure[data-slot=\"0\"] canvas').getBoundingClientRect(); return [x, y, width, height]"
        before = b.script(box)
        b.find('figure[data-slot="0"] canvas').click()
        wait(lambda: "You drive" in b.text("#hint"), "driving")
        self.assertEqual(b.script(box), before)
        b.script("padr.driver.release()")
        wait(lambda: b.script("return !document.querySelector('#save').hidden"), "the link to the path")
        self.assertEqual(b.script(box), before)

    def test_settings_are_small_marks_in_plots(self):
        b = self.page(1280, 757)
        marks = b.module("return (await import('/plots.js')).MARKS")
        for kind in ("knob", "netem", "pause", "push"):
            self.assertEqual(marks[kind], "setting")
        for kind in ("cut", "joined", "removed"):
            self.assertNotIn(kind, marks)

    def test_phone(self):
        b = self.page(390, 844, phone=True)
        picture = b.script("const box = document.querySelector('#views').getBoundingClientRect(); return [box.top, box.height]")
        self.assertLess(picture[0], 60)
        self.assertGreaterEqual(picture[1], 844 / 2)
        self.assertEqual(b.script(CUT_OFF), [])
        self.assertIn("finger", b.text("#intro"))
        b.picture("look-phone")

        def look(step):
            self.assertNotIn("WASD", b.text("#tour"), f"step {step}")
            high = b.script("return document.querySelector('#tour').getBoundingClientRect().top")
            self.assertGreater(high, 844 / 2)
            b.picture(f"look-phone-tour-{step}")

        self.take_tour(b, look)
        # A finger makes another picture the large one, and drives its avatar.
        b.find('figure[data-slot="2"] canvas').click()
        wait(lambda: b.script("return document.querySelector('figure.big').dataset.slot") == "2", "the large picture")
        wait(lambda: "Hold a finger" in b.text("#hint"), "words for a thumb")
        b.script("padr.driver.release()")
        self.check_console(b)

    def test_recording_on_a_phone(self):
        b = Browser(390, 844, phone=True)
        self.addCleanup(b.close)
        b.open(self.monitor.address + "?sample=bad-network-full")
        wait(lambda: b.script("return padr.session.timeline && padr.session.present().length") == 4, "the recording")
        box = "const box = document.querySelector(arguments[0]).getBoundingClientRect(); return [box.top, box.bottom]"
        wait(lambda: b.script(box, "#views")[1] > 400, "the pictures")
        top, bottom = b.script(box, "#views")
        self.assertLess(top, 60)
        self.assertGreaterEqual(bottom - top, 844 / 2)
        line = b.script(box, "#replay")
        self.assertGreater(line[0], bottom, "the time line hides no picture")
        self.assertLessEqual(line[1], 844)
        self.assertEqual(b.script(CUT_OFF), [])
        b.picture("look-phone-recording")
        self.check_console(b)


if __name__ == "__main__":
    main()
