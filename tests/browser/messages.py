#!/usr/bin/env python3
"""What the page makes of messages that real peers send rarely, or only after a long time. The messages are made up here; the
monitor has no peers. See browser.py."""

import json

from browser import *
from selenium.webdriver.common.keys import Keys

KNOBS = {"threshold": "0.014:0.012", "body-threshold": "0.012", "replay": "on", "model": "auto", "predictor": "pcc", "convergence": "track"}
SCENE = {
    "type": "scene", "session": 26, "name": "arena", "scenario": "arena", "title": "made up", "seed": 1, "slots": 24, "tick_rate": 60,
    "lower": [0, 0], "upper": [20, 15], "gravity": [0, 0], "avatar": {"radius": 0.4, "mass": 80, "max_speed": 5}, "spawns": [],
    "bodies": [{"id": 0, "shape": "circle", "radius": 0.3, "mass": 5, "position": [5, 5], "angle": 0}], "statics": [],
}  # fmt: skip
CHOSEN = "return Object.fromEntries([...document.querySelectorAll('#knobs select')].map((s) => [s.name, s.value]))"
SLIDERS = "return [...document.querySelectorAll('#knobs output')].map((o) => o.textContent)"


def link(to, **more):
    return {"to": to, "delay_ms": 50, "delay_p95_ms": 60, "delay_least_ms": 40, "round_trip_ms": 100, "loss_percent": 0, "loss_of": 192, "lost": 0,
            "judged": 900, "carries_kbit_s": None, "queue_ms": 0, "carried_by": None, "netem": "", "cut": None, **more}  # fmt: skip


def peer(slot, count=3, **more):
    return {
        "slot": slot, "incarnation": slot, "state": "here", "heard_ms": 10, "address": f"127.0.0.1:{9000 + slot}", "version": "0.4.0",
        "technique": "full", "settings": "full", "knobs": KNOBS, "controllable": True, "driven": "no", "detail": "all", "input": "wander",
        "tick": 600, "rates": None, "confirmed": {"tick": 590, "hash": "0" * 16, "state": "identical", "lag_ms": 160}, "hash_mismatches": 0,
        "late_ticks": 0, "lateness_ms": 0.1, "own_error_m": 0.01, "price": 1, "paused": False, "frames": {"received": 100, "lost": 0},
        "links": [link(to) for to in range(count) if to != slot], "drops": [], **more,
    }  # fmt: skip


def peers(all_peers, tick=600, state="identical", compared=50, **more):
    return {"type": "peers", "session": 26, "tick": tick, "time": tick / 60, "other_sessions": 0,
            "agreement": {"state": state, "compared": compared, "tick": tick - 10, "first_difference": None}, "peers": all_peers, **more}  # fmt: skip


def series(tick, values):
    return {"type": "series", "tick": tick, "time": tick / 60, "peers": [
        {"slot": slot, "at_tick": tick - 60, "combined_m": m, "avatars_m": m, "bodies_m": 0, "shown_m": m, "fidelity_m": None, "pcc_m": None,
         "updates_per_s": [1, 2, 3], "kbit_per_s": 4, "lag_ms": 200, "threshold_m": 0.8, "delay_ms": {}} for slot, m in enumerate(values)]}  # fmt: skip


class Messages(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        cls.browser = cls.start(Browser(1280, 800))

    def page(self, hello=None, all_peers=None):
        """A page to which a session has been told."""
        b = self.browser
        b.open(self.monitor.address)
        wait(lambda: b.script("return padr.session.hello !== null"), "hello")
        self.tell({**b.script("return padr.session.hello"), **(hello or {})}, SCENE, peers([peer(i) for i in range(3)] if all_peers is None else all_peers))
        return b

    def tell(self, *messages):
        for message in messages:
            self.browser.script("padr.connection.receive(arguments[0])", json.dumps(message))

    def tearDown(self):
        self.check_console(self.browser)

    # Once, without control they showed what the page begins with: avatar-only, and thresholds of 1 m.
    def test_knobs_show_what_peers_have_without_control(self):
        for hello, all_peers in (({"control": False}, None), ({}, [peer(i, controllable=False) for i in range(3)])):
            b = self.page(hello, all_peers)
            chosen = b.script(CHOSEN)
            self.assertEqual([chosen[n] for n in ("technique", "model", "predictor", "convergence", "network")], ["full", "auto", "pcc", "track", ""])
            self.assertEqual(b.script(SLIDERS), ["1.4 cm", "1.2 cm", "1.2 cm"])
            self.assertTrue(b.script("return [...document.querySelectorAll('#knobs fieldset')].every((f) => f.disabled)"))

    # Once, they showed the end of the slider, and one key set that.
    def test_sliders_stand_for_what_is_in_force(self):
        b = self.page(None, [peer(i, knobs={**KNOBS, "threshold": "5:3", "body-threshold": "0.0025"}) for i in range(3)])
        self.assertEqual(b.script(SLIDERS), ["5.0 m", "3.0 m", "3 mm"])
        texts = "return [...document.querySelectorAll('#knobs input[type=range]')].map((i) => i.getAttribute('aria-valuetext'))"
        self.assertEqual(b.script(texts), ["5.0 m", "3.0 m", "3 mm"])
        b.script("window.asked = []; padr.connection.ask = (m) => { window.asked.push(m); return Promise.resolve({ ok: true, text: '' }); }")
        for name, sent in (("low", "5:1.99"), ("high", "1.99")):
            b.find(f'[name="{name}"]').send_keys(Keys.ARROW_LEFT)
            self.assertEqual(b.script("return window.asked.at(-1).value"), sent)

    # Once, they were written only while a plot was on the screen.
    def test_values_of_plots_are_told_wherever_the_page_stands(self):
        self.addCleanup(self.browser.resize, 1280, 800)
        self.browser.resize(1280, 400)
        b = self.page()
        wait(lambda: not b.script("return padr.plots.shown"), "no plot on the screen")
        for tick, value in ((600, 0.25), (615, 0.75)):
            self.tell(series(tick, [value, 0.1, 0.1]))
            wait(lambda: f"peer 0 {value:.2f} m" in b.text("#plots .values"), "the new value")

    # Once, a screen reader said the picture's name again with each new error, and buttons of all peers had one name.
    def test_names_stand_still_and_differ(self):
        b = self.page()
        names = "return [...document.querySelectorAll('#views canvas')].map((c) => c.getAttribute('aria-label'))"
        before = b.script(names)
        self.assertEqual(before[1], "View of peer 1. Enter drives its avatar.")
        self.tell(series(600, [0.25, 0.5, 0.75]))
        wait(lambda: "0.5 m off" in b.text('figure[data-slot="1"] .said'), "the caption")
        self.assertEqual(b.script(names), before)
        buttons = b.script("return [...document.querySelectorAll('#views button')].map((x) => x.getAttribute('aria-label'))")
        self.assertEqual(buttons[:4], ["Drive, peer 0", "Follow, peer 0", "Enlarge, peer 0", "Drive, peer 1"])
        self.assertEqual(len(set(buttons)), 9)

    # Once, it scrolled the page.
    def test_space_does_nothing_on_a_picture(self):
        b = self.page()
        scrolled = "return scrollY"
        b.script("padr.connection.ask = () => Promise.resolve({ ok: true, text: '' })")
        canvas = b.find('figure[data-slot="0"] canvas')
        b.script("arguments[0].focus({ preventScroll: true })", canvas)
        canvas.send_keys(" ")
        b.script("padr.driver.start(0)")
        b.script("document.activeElement.blur()")
        b.find("body").send_keys(" ")
        time.sleep(0.5)
        self.assertEqual(b.script(scrolled), 0)
        b.script("padr.driver.forget(null)")
        b.find("body").send_keys(" ")
        wait(lambda: b.script(scrolled) > 0, "it to scroll where nobody drives")

    # Once, they stood in the order in which they had come.
    def test_events_are_listed_by_time(self):
        b = self.page()
        event = {"tick": 60, "peer": 0, "entity": None, "other": None, "text": "", "kind": "pause"}
        self.tell({"type": "events", "events": [{**event, "time": t} for t in (3, 1, 2)]})
        items = b.script("padr.events.show(true); return [...document.querySelectorAll('#events li')].map((n) => n.textContent)")
        self.assertEqual([i.split()[0] for i in items], ["0:03", "0:02", "0:01"])

    # Once, only who pointed at a cell could read them.
    def test_what_cells_tell_can_be_read_without_a_mouse(self):
        drops = [{"from": 2, "cut_off": 1, "by_reason": {"malformed": 20}}]
        b = self.page(None, [peer(0, settings="full --lead 0.05", drops=drops), peer(1)])
        told = b.text("#details")
        for words in ("peer 0: full --lead 0.05; version 0.4.0. Dropped of peer 2: 20 malformed; cut off, 1 time.", "traffic: Sent, with IP"):
            self.assertIn(words, told)
        self.assertEqual(b.script("return [...document.querySelectorAll('#peers tbody th')].map((c) => c.scope)"), ["row", "row"])

    # Once, only a double click did.
    def test_plots_of_a_recording_are_shown_whole_again(self):
        b = self.page({"mode": "trace", "control": False})
        button = b.find('[data-span="all"]')
        self.assertEqual(button.get_attribute("aria-pressed"), "true")
        b.script("padr.plots.select([1, 2])")
        self.assertEqual(button.get_attribute("aria-pressed"), "false")
        b.script("arguments[0].focus()", button)
        button.send_keys(Keys.ENTER)
        self.assertIsNone(b.script("return padr.plots.selected"))

    # Once, contacts and changes of authority alone filled it, and the list stood empty without a word.
    def test_frequent_events_leave_room_for_the_others(self):
        b = self.page()
        items = "padr.events.show(true); return [...document.querySelector('#events').childNodes].map((n) => n.textContent)"
        self.assertEqual(b.script(items), ["nothing yet"])
        event = {"tick": 60, "time": 1, "peer": 0, "entity": None, "other": None, "text": ""}
        self.tell({"type": "events", "events": [{**event, "kind": "cut"}]})
        for _ in range(11):
            self.tell({"type": "events", "events": [{**event, "kind": "authority", "entity": 0, "other": 1}] * 1000})
        self.assertIn("peer 0: cut off from all", b.script(items)[0])
        self.assertLessEqual(b.script("return padr.events.list.length"), 10000)

    # Once, its table had the values of the position before.
    def test_the_table_of_a_halted_recording_follows_it(self):
        b = self.page({"mode": "trace", "control": False})
        self.tell({"type": "timeline", "first": 0, "last": 900, "tick": 600, "playing": False, "speed": 1, "sample": 1})
        for value in (0.25, 0.75):
            self.tell(peers([peer(i) for i in range(3)]), series(600, [value, 0.1, 0.1]))
            self.assertIn(f"{value:.2f} m", b.text("#peers tbody tr"))

    # Once, below a picture with long lines stood a small error: that of a moment before.
    def test_an_error_of_another_moment_says_of_which(self):
        b = self.page({"mode": "trace", "control": False})
        said = "return document.querySelector('figure[data-slot=\"0\"] .said').textContent"
        line = {"type": "timeline", "first": 0, "last": 900, "tick": 600, "playing": False, "speed": 1, "sample": 2}
        for at, playing, words in ((599, False, "0.3 m off"), (555, False, "0.3 m off at 0:09.3"), (555, True, "0.3 m off")):
            point = series(600, [0.25, 0.1, 0.1])
            point["peers"][0]["at_tick"] = at
            self.tell({**line, "playing": playing}, point, peers([peer(i) for i in range(3)]))
            self.assertEqual(b.script(said), words)

    # Once, its caption said that the error is not known, and the table said 0.00 m.
    def test_the_error_of_a_peer_that_is_cut_off_is_known_nowhere(self):
        b = self.page()
        apart = peer(2, confirmed={"tick": 590, "hash": "1" * 16, "state": "apart", "lag_ms": 160})
        cut = peer(1, links=[link(0, cut="both"), link(2)])
        self.tell(series(600, [0.25, 0, 0]), peers([peer(0), cut, apart]))
        self.assertEqual(b.script("return [...document.querySelectorAll('#peers tbody tr')].map((r) => r.cells[4].textContent)"), ["0.25 m", "–", "–"])
        for slot in (1, 2):
            wait(lambda: "error not known" in b.text(f'figure[data-slot="{slot}"] .said'), "its caption to say so")

    # Once, plots that the tour hides were made in boxes of no size, and were 480 pixels wide and 320 high from then on.
    def test_plots_that_the_tour_hides_fit_their_cards_afterwards(self):
        self.addCleanup(self.browser.resize, 1280, 800)
        for size in ((1280, 800), (390, 844)):
            self.browser.resize(*size)
            b = self.page()
            b.script("padr.connection.ask = () => Promise.resolve({ ok: true, text: '' }); padr.tour.start()")
            for tick in range(600, 720, 15):
                self.tell(series(tick, [0.1, 0.2, 0.3]))
            made = "return padr.plots.charts.map((c) => c.graph !== undefined)"
            b.script("document.querySelector('#plots').scrollIntoView()")
            wait(lambda: b.script(made)[:2] == [True, True], "the plots of the step")
            b.script("padr.plots.redraw(); padr.tour.end()")
            b.script("document.querySelector('#plots').scrollIntoView()")
            wait(lambda: b.script(made) == [True] * 4, "all plots")
            sizes = "return padr.plots.charts.map((c) => [c.box.style.width, c.box.clientHeight, Math.abs(c.box.clientWidth - c.graph.width_) <= 1])"
            wait(lambda: b.script(sizes) == [["", 170, True]] * 4, "plots that fit their cards")
            self.assertEqual(b.script("return document.documentElement.scrollWidth"), size[0])

    # Once, it said that the session was over, while peers played on.
    def test_the_end_of_the_program_is_not_that_of_the_session(self):
        b = self.page()
        b.script("padr.connection.tell('lost', true)")
        self.assertIn("padr-monitor has ended; the peers may play on.", b.text("#error"))
        self.tell(peers([peer(i, state="gone") for i in range(3)]))
        self.assertEqual(b.text("#state"), "over, 0:10")
        b.script("padr.connection.tell('lost', true)")
        self.assertEqual(b.text("#error"), "The session is over.")
        # So it is to who comes then.
        self.page(None, [peer(i, state="gone") for i in range(3)])
        self.assertEqual(b.text("#state"), "over, 0:10")
        self.assertEqual(b.text("#empty"), "The session is over.")
        # Once, it was live again to who came after a minute, when those who have gone are forgotten.
        self.page(None, [])
        self.assertEqual(b.text("#state"), "over, 0:10")
        self.assertEqual(b.text("#empty"), "The session is over.")
        self.assertFalse(b.script("return document.body.classList.contains('empty')"))

    # Once, the next click made it "live" again, captions stood as if they were of now, and knobs could be turned.
    def test_without_connection_nothing_is_live(self):
        b = self.page()
        self.tell(series(600, [0.25, 0.1, 0.1]))
        b.script("padr.connection.tell('lost', false)")
        for _ in range(2):
            self.assertEqual(b.text("#state"), "not connected")
            self.assertIn("lost", b.text("#error"))
            said = "return document.querySelector('figure[data-slot=\"0\"] .said').textContent"
            wait(lambda: b.script(said) == "not connected", "the caption to say so")
            self.assertTrue(b.script("return [...document.querySelectorAll('#knobs fieldset')].every((f) => f.disabled)"))
            self.assertEqual(b.text("#knobs .why"), "Not connected to padr-monitor.")
            self.assertFalse(b.find("#tour-button").is_enabled())
            self.assertNotIn("may only look", b.text("#intro"))
            b.find('button[data-mode="overlay"]').click()
            b.find('button[data-mode="side"]').click()
        b.script("padr.connection.tell('open')")
        self.tell(peers([peer(i) for i in range(3)]))
        self.assertEqual(b.text("#state"), "live, 0:10")
        self.assertTrue(b.find("#tour-button").is_enabled())

    # Once, an error stood in its plot up to a second after the event that made it.
    def test_an_error_is_plotted_when_it_was_there(self):
        b = self.page()
        for tick in (600, 615, 630):
            self.tell(series(tick, [0.1, None, 0.2]))
        silent = series(645, [None, None, None])
        for p in silent["peers"]:
            p["at_tick"] = None
        self.tell(silent, series(660, [0.1, 0.2, 0.3]))
        b.script("document.querySelector('#plots').scrollIntoView()")
        times = "return padr.plots.charts.map((c) => c.rows.map((r) => r[0]))"
        wait(lambda: [len(rows) for rows in b.script(times)] == [5] * 4, "all rows")
        errors, updates, *_ = b.script(times)
        self.assertEqual(errors, [9, 9.25, 9.5, 10.75, 10.75])
        self.assertEqual(updates, [10, 10.25, 10.5, 10.75, 11])
        b.script("padr.plots.hover(10.4, padr.plots.charts[1])")
        self.assertEqual(b.script("return [...document.querySelectorAll('#plots .values b')].map((e) => e.textContent)"), ["0:10.4"] * 4)

    # Once, captions below small pictures broke into three lines of a few letters, and the words in pictures were wider than these.
    def test_captions_of_small_pictures_can_be_read(self):
        self.addCleanup(self.browser.resize, 1280, 800)
        for count, size, scale in ((20, (1280, 800), 1), (4, (640, 400), 2)):
            self.browser.resize(*size, scale=scale)
            b = self.page(None, [peer(i, count) for i in range(count)])
            self.tell(series(600, [16.4] * count))
            wait(lambda: "16 m off" in b.text(f'figure[data-slot="{count - 1}"] .said'), "an error in each caption")
            wrong = b.script("""return [...document.querySelectorAll("#views figcaption")].flatMap((caption) => {
              const said = caption.querySelector(".said"), picture = caption.parentElement.querySelector("canvas").getBoundingClientRect();
              const parts = [...caption.querySelectorAll("strong, .said, button")].filter((e) => e.getClientRects().length > 0);
              const boxes = parts.map((e) => e.getBoundingClientRect());
              return [
                said.scrollWidth > said.clientWidth && "cut off", said.clientHeight > 20 && "more than a line",
                boxes.some((a, i) => boxes.some((b, k) => k < i && a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1)) && "overlap",
                boxes.some((a) => a.right > picture.right + 3) && "wider than the picture",
              ].filter(Boolean);
            })""")
            self.assertEqual(wrong, [], size)
            b.picture(f"captions-{count}")
            widest = b.script("""const { ctx } = padr.views.tiles.get(0); let most = 0;
              ctx.fillRect = function (x, y, w) { most = Math.max(most, w); return CanvasRenderingContext2D.prototype.fillRect.apply(this, arguments); };
              padr.views.say(padr.views.tiles.get(0), "silent: no news from this peer"); delete ctx.fillRect; return [most, padr.views.tiles.get(0).width]""")
            self.assertLessEqual(widest[0], widest[1] + 1)

    # Once, such lists were empty, or said "as written below" of networks where nothing was written.
    def test_lists_say_where_peers_differ(self):
        other = {**KNOBS, "model": "first", "convergence": "pvb", "predictor": "none"}
        b = self.page(None, [peer(0), peer(1, knobs=other, technique="adaptive", links=[link(0, netem="delay 20ms"), link(2)]), peer(2)])
        shown = "return ['technique', 'model', 'predictor', 'convergence', 'network'].map((n) => document.querySelector(`[name=${n}]`).selectedOptions[0].text)"
        self.assertEqual(b.script(shown), ["differ"] * 5)
        b.picture("lists-differ")
        self.tell(peers([peer(i) for i in range(3)]))
        self.assertEqual(b.script(shown), ["full", "auto", "pcc", "track: time-optimal", "perfect"])
        self.assertEqual(b.script("return document.querySelectorAll('#knobs option[value=differ]').length"), 0)

    # Once, the link stayed, and the program no longer had the path.
    def test_a_path_can_be_saved_until_the_next_session(self):
        b = self.page()
        b.script("padr.driver.start(0)")
        b.script("padr.driver.release()")
        hidden = "return document.querySelector('#save').hidden"
        self.assertFalse(b.script(hidden))
        self.tell({**SCENE, "session": 27}, peers([peer(i) for i in range(3)]))
        self.assertTrue(b.script(hidden))

    # Once, they were numbers of nothing, and small ones had exponents.
    def test_plots_have_units_and_plain_numbers(self):
        b = self.page()
        for tick in range(600, 900, 15):
            self.tell(series(tick, [0.004, 0.005, None]))
        b.script("document.querySelector('#plots').scrollIntoView()")
        read = "return [...document.querySelectorAll('#plots .values')].map((v) => v.querySelector('span')?.textContent)"
        wait(lambda: [r and r.split()[-1] for r in b.script(read)][:3] == ["m", "/s", "ms"], "units")
        axes = b.script("return [...document.querySelectorAll('.dygraph-axis-label-y')].map((e) => e.textContent)")
        self.assertIn("0.004", axes)
        self.assertEqual([a for a in axes if "e" in a], [])

    # Once, live it had a column that is of recordings only, and an address that is not told was blank.
    def test_the_table_has_what_is_known(self):
        for mode, more in (("live", 0), ("trace", 1)):
            b = self.page({"mode": mode}, [peer(0, address="")])
            head = b.script("return [...document.querySelectorAll('#peers thead th')].map((e) => e.textContent)")
            self.assertEqual(head.count("fidelity error"), more)
            # Plots of a recording always have all of it.
            self.assertEqual(b.find("[data-span]").is_displayed(), mode == "live")
            self.assertEqual(b.text("#plots-head"), {"live": "As it happens", "trace": "Over time"}[mode])
            self.assertEqual(len(head), 15 + more)
            self.assertEqual(b.script("return document.querySelector('#peers tbody tr').cells[arguments[0]].textContent", head.index("address")), "–")

    def test_the_session_has_its_number_and_others_are_counted(self):
        b = self.page()
        self.assertEqual(b.text("#table-head"), "Peers of session 26")
        for count, words in ((0, "live, 0:10"), (1, "live, 0:10, 1 other session"), (2, "live, 0:10, 2 other sessions")):
            self.tell(peers([peer(0)], other_sessions=count))
            self.assertEqual(b.text("#state"), words)

    # Once, it stayed where the avatar had last been.
    def test_the_camera_follows_nobody_who_is_gone(self):
        b = self.page()
        b.script("padr.camera.follow = 2")
        self.tell(peers([peer(i) for i in range(3)]))
        self.assertEqual(b.script("return padr.camera.follow"), 2)
        self.tell(peers([peer(0), peer(1), peer(2, state="gone")]))
        self.assertIsNone(b.script("return padr.camera.follow"))

    def test_a_peer_that_is_alone_may_wait_for_others(self):
        b = self.page(None, [peer(0, 1)])
        self.assertIn("--wait-peers", b.text("#intro"))
        self.tell(peers([peer(0), peer(1)]))
        self.assertNotIn("--wait-peers", b.text("#intro"))

    # Once, it said that the session was live, and let one drive what does not move.
    def test_peers_that_wait_for_others_cannot_be_driven(self):
        b = self.page(None, [peer(0, 2), peer(1, 2)])
        view = """const [tick, x, awake] = given;
          for (const slot of [0, 1]) {
            const d = new DataView(new ArrayBuffer(40));
            d.setUint8(0, 1); d.setUint8(1, slot); d.setInt32(4, tick, true); d.setFloat32(12, NaN, true); d.setUint16(20, 1, true);
            d.setUint8(26, 255); d.setUint8(27, awake); d.setFloat32(28, x, true); d.setFloat32(32, 5, true);
            padr.session.samples.take(d.buffer);
          }
          padr.session.samples.now = tick;"""
        drives = "return [...document.querySelectorAll('#views .drive')].map((b) => b.hidden)"
        self.assertEqual(b.script(drives), [False, False])
        b.module(view, 600, 5.0004, 1)
        self.tell(peers([peer(0, 2), peer(1, 2)]))
        self.assertEqual(b.text("#state"), "waiting for more peers, 0:10")
        self.assertIn("Two programs are here, and they wait for more, as --wait-peers says.", b.text("#intro .text"))
        self.assertEqual(b.script(drives), [True, True])
        self.assertFalse(b.find("#tour-button").is_enabled())
        # Whatever nobody touches is asleep soon after play has begun; what is pushed is not.
        b.module(view, 640, 5.0004, 0)
        self.tell(peers([peer(0, 2), peer(1, 2)]))
        self.assertEqual(b.text("#state"), "live, 0:10")
        self.assertEqual(b.script(drives), [False, False])
        b.module(view, 700, 5.0004, 1)
        self.tell(peers([peer(0, 2), peer(1, 2)]))
        self.assertEqual(b.text("#state"), "live, 0:10", "it has begun for good")

    # Once, lines of peers that are gone were pale.
    def test_what_is_said_of_who_is_gone_can_be_read(self):
        with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "reach.js"), encoding="utf-8") as file:
            rules = file.read().replace("export ", "")
        for theme in ("light", "dark"):
            b = self.page(None, [peer(0), peer(1), peer(2, state="gone")])
            b.script("document.documentElement.dataset.theme = arguments[0]", theme)
            self.assertEqual(b.script(f"{rules}\nreturn contrasts();"), [])

    # Once, "identical" stood beside hashes that differed, as each was of another tick.
    def test_hashes_say_of_which_tick_they_are(self):
        other = {"tick": 576, "hash": "1" * 16, "state": "identical", "lag_ms": 400}
        b = self.page(None, [peer(0), peer(1, confirmed=other), peer(2, state="gone")])
        cells = b.script("return [...document.querySelectorAll('#peers tbody tr')].map((r) => [...r.cells].slice(2, 4).map((c) => c.textContent))")
        self.assertEqual(cells, [["✓ identical 00000000 at 590", "160 ms"], ["✓ identical 11111111 at 576", "400 ms"], ["–", "–"]])

    # Once, a spectator was counted as playing, and could be followed, though it has no avatar.
    def test_a_spectator_only_watches(self):
        b = self.page(None, [peer(0), peer(1), peer(2, input="none")])
        self.assertIn("Two programs play, and one watches, in one world without a server", b.text("#intro .text"))
        hidden = "return [...document.querySelectorAll('#views .follow')].map((f) => f.hidden)"
        self.assertEqual(b.script(hidden), [False, False, True])
        b.script("padr.connection.ask = () => Promise.resolve({ ok: true, text: '' }); padr.tour.start()")
        self.assertIn("2 programs play in one world", b.text("#tour .text"))
        b.script("padr.tour.end()")

    # Once, such a click did nothing, and nothing was said.
    def test_a_click_that_cannot_drive_says_why(self):
        cases = (
            ({}, {"input": "none"}, "Peer 1 is a spectator: it has no avatar to drive."),
            ({}, {"controllable": False}, "Peer 1 takes no orders, as it was started without --control."),
            ({"control": False}, {}, "This page may only look."),
        )
        for hello, more, words in cases:
            b = self.page(hello, [peer(0), peer(1, **more), peer(2)])
            self.assertEqual(b.text("#hint"), "")
            b.find('figure[data-slot="1"] canvas').click()
            self.assertEqual(b.text("#hint"), words)
            self.assertIsNone(b.script("return padr.driver.slot"))

    # Once, outlines of all colours lay over it without a word.
    def test_overlaid_pictures_are_explained(self):
        b = self.page()
        b.find('button[data-mode="overlay"]').click()
        self.assertIn("outlines in a peer's colour", b.text("#views .said"))
        self.assertIn("overlaid:", b.text("#legend"))
        b.picture("overlaid-caption")

    # Once, the tour filled such a screen, or was out of sight as soon as a picture was in it.
    def test_on_a_low_screen_the_tour_stands_beside_the_pictures(self):
        self.addCleanup(self.browser.resize, 1280, 800)
        for size, scale in (((844, 390), 2), ((640, 400), 2), ((1024, 600), 1)):
            self.browser.resize(*size, scale=scale)
            b = self.page(None, [peer(i, 4) for i in range(4)])
            b.script("padr.connection.ask = () => Promise.resolve({ ok: true, text: '' }); padr.tour.start()")
            for step in range(9):
                self.tell(peers([peer(i, 4) for i in range(4)]), series(600 + 15 * step, [0.1] * 4))
                outside = b.script("""const tour = document.querySelector("#tour").getBoundingClientRect();
                  return ["#tour .back", "#tour .next", "#tour .end", "#tour .title", "#views canvas", "#views figure:nth-child(4) canvas"].filter((name) => {
                    const r = document.querySelector(name).getBoundingClientRect();
                    return r.top < 0 || r.bottom > innerHeight + 1 || r.left < 0 || r.right > innerWidth || (name.includes("canvas") && r.left < tour.right);
                  })""")
                self.assertEqual(outside, [], (size, step + 1))
                self.assertGreater(b.script("return document.querySelector('#views canvas').clientWidth"), 120)
                if step in (0, 3, 8):
                    b.picture(f"low-{size[0]}-tour-{step + 1}")
                b.script("scrollTo(0, 400)")
                self.assertTrue(b.find("#tour .back").is_displayed())
                top = b.script("const r = document.querySelector('#tour .end').getBoundingClientRect(); return r.top >= 0 && r.bottom <= innerHeight")
                self.assertTrue(top, "its buttons stay")
                b.script("document.querySelector('#tour .next').click()")
                b.script("scrollTo(0, 0)")
            b.script("padr.tour.end()")
            self.assertEqual(b.script("return getComputedStyle(document.body).paddingLeft"), "12px")

    # Once, links of one machine had "-0 ms".
    def test_no_zero_is_negative(self):
        got = self.page().module("""
          const { number } = await import("/table.js");
          return [number(-0.05, 0, " ms"), number(-0.04, 1, " ms"), number(-0.6, 0, " ms"), number(-10, 0), number(0, 2), number(null, 1)];
        """)
        self.assertEqual(got, ["0 ms", "0.0 ms", "-1 ms", "-10", "0.00", "–"])

    # Once, of five peers' links those to peers 0, 2 and 4 looked alike.
    def test_no_two_links_look_alike(self):
        b = self.page(None, [peer(i, 5) for i in range(5)])
        for tick in range(600, 900, 15):
            point = series(tick, [0.1] * 5)
            for p in point["peers"]:
                p["delay_ms"] = {str(to): 40 + 5 * to + p["slot"] for to in range(5) if to != p["slot"]}
            self.tell(point)
        b.script("document.querySelector('#plots').scrollIntoView()")
        looks = "return padr.plots.charts[3].lines?.map((l) => [l.colour, l.dash].join())"
        wait(lambda: len(b.script(looks) or []) == 20, "twenty links")
        self.assertEqual(len(set(b.script(looks))), 20)
        shown = b.script("return [...document.querySelectorAll('#plots figure:nth-child(4) .values span')].map((s) => getComputedStyle(s, '::before').backgroundImage)")
        self.assertEqual(len(set(shown)), 20)
        self.assertNotIn("none", shown)
        time.sleep(0.6)
        b.picture("links")


class Token(Case):
    SECRET = "ab+cd/ef=="  # as base64 has it

    def open(self, monitor, end=""):
        b = self.start(Browser())
        b.open(monitor.address + end)
        wait(lambda: b.script("return padr.session.hello !== null"), "hello")
        return b

    # Once, it was read when the page was loaded, and never again; and a "+" in it was a blank.
    def test_it_may_be_added_to_the_address_of_an_open_page(self):
        b = self.open(self.start(Monitor("--control-token", self.SECRET)))
        control = "return padr.session.hello.control"
        self.assertFalse(b.script(control))
        b.script("location.hash = 'token=wrong'")
        wait(lambda: "not the token" in b.text("#error"), "the complaint")
        b.script("location.hash = 'token=' + arguments[0]", self.SECRET)
        wait(lambda: b.script(control), "control")
        self.assertTrue(b.script("return document.querySelector('#error').hidden"))

    # Once, it said that this is not the token.
    def test_where_none_is_needed_it_is_of_no_account(self):
        b = self.open(self.start(Monitor()), "#token=x")
        self.assertTrue(b.script("return padr.session.hello.control"))
        time.sleep(0.5)
        self.assertEqual(b.text("#error"), "")


if __name__ == "__main__":
    main()
