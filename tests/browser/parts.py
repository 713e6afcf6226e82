#!/usr/bin/env python3
"""Parts of the page by themselves, in Chromium: what a session would rarely bring about. See browser.py."""

from browser import *

# An hour of a session of 12 peers on the pitch, as messages; `given` is how many seconds of it, and from which on.
HOUR = """
  const [seconds, from] = given;
  const slots = [...Array(12).keys()];
  const size = 1 + 12;
  const block = (slot, view, tick) => {
    const data = new DataView(new ArrayBuffer(24 + 16 * size));
    data.setUint8(0, 1); data.setUint8(1, slot); data.setUint8(2, view);
    data.setInt32(4, tick, true); data.setFloat32(8, 0.8, true); data.setFloat32(12, NaN, true); data.setUint16(20, size, true);
    for (let id = 0; id < size; ++id) {
      const at = 24 + 16 * id;
      data.setUint16(at, id, true); data.setUint8(at + 2, id ? id - 1 : 255); data.setUint8(at + 3, 1);
      data.setFloat32(at + 4, 50 + 10 * Math.sin(tick / 100 + id), true); data.setFloat32(at + 8, 30, true);
    }
    return data.buffer;
  };
  for (let s = from; s < from + seconds; ++s) {
    for (let quarter = 0; quarter < 4; ++quarter) {
      const time = s + quarter / 4;
      padr.connection.receive(JSON.stringify({ type: "series", tick: time * 60, time, peers: slots.map((slot) => ({
        slot, at_tick: time * 60, combined_m: Math.random(), avatars_m: 0.1, bodies_m: 0.1, shown_m: 0.1, updates_per_s: [1, 2, 3],
        kbit_per_s: 4, lag_ms: 300, threshold_m: 0.8, delay_ms: Object.fromEntries(slots.map((t) => [t, 50])) })) }));
    }
    padr.connection.receive(JSON.stringify({ type: "events", events: Array(6).fill({ tick: s * 60, time: s, peer: 1, kind: "contact_begin", entity: 3, other: null, text: "touches body 3" }) }));
    for (let f = 0; f < 20; ++f) {
      for (const slot of slots) padr.session.samples.take(block(slot, 0, s * 60 + f * 3));
      padr.session.samples.take(block(255, 4, s * 60 + f * 3));
      padr.session.samples.advance(0.05, 1);
    }
    if (s % 60 === 0) padr.plots.redraw();
  }
"""


class Parts(Case):
    @classmethod
    def setUpClass(cls):
        cls.monitor = cls.start(Monitor())
        cls.browser = cls.start(Browser())
        cls.browser.open(cls.monitor.address)

    def test_without_peers_it_says_what_to_do(self):
        wait(lambda: "--monitor" in self.browser.text("#empty"), "the hint")
        self.assertIn(self.monitor.peers, self.browser.text("#empty"))
        # Once, the command was for one peer, which waits for a second one for ever.
        for words in ("padr-peer --listen 127.0.0.1:7001 --monitor", "padr-peer --join 127.0.0.1:7001 --monitor"):
            self.assertIn(words, self.browser.text("#empty"))
        # Once, the column of the knobs was kept free, which are not there.
        free = "return document.querySelector('main').clientWidth - document.querySelector('#stage').clientWidth"
        self.assertEqual(self.browser.script(free), 0)
        self.browser.picture("empty")
        self.check_console(self.browser)

    def test_camera_keeps_the_point_under_the_pointer(self):
        self.assertTrue(self.browser.module("""
          const { Camera, toWorld } = await import("/camera.js");
          const camera = new Camera();
          camera.setArea({ x: -10, y: 0 }, { x: 30, y: 20 });
          const before = toWorld(camera.fit(400, 300), 100, 250);
          camera.zoomAbout(before, 3);
          const after = toWorld(camera.fit(400, 300), 100, 250);
          return Math.hypot(before.x - after.x, before.y - after.y) < 1e-9 && camera.zoom === 3;
        """))

    def test_views_in_between(self):
        got = self.browser.module("""
          const { Samples } = await import("/samples.js");
          const samples = new Samples();
          samples.begin(2);
          const block = (tick, records) => {
            const data = new DataView(new ArrayBuffer(24 + 16 * records.length));
            data.setUint8(0, 1); data.setUint8(1, 3); data.setInt32(4, tick, true); data.setFloat32(12, NaN, true);
            data.setUint16(20, records.length, true);
            records.forEach(([id, x, angle], i) => {
              data.setUint16(24 + 16 * i, id, true); data.setUint8(24 + 16 * i + 3, 1);
              data.setFloat32(24 + 16 * i + 4, x, true); data.setFloat32(24 + 16 * i + 12, angle, true);
            });
            return data.buffer;
          };
          samples.take(block(60, [[0, 1, 3], [1, 0, 0]]));
          samples.take(block(64, [[0, 2, -3], [1, 9, 0]]));
          const at = (tick) => { samples.now = tick; const { x, angle } = samples.sample(3, 0).world; return [x[0], angle[0], x[1]]; };
          const seen = [at(50), at(62), at(70)];
          samples.take(block(20, [[0, 7, 0]]));           // back in time: the others are forgotten
          seen.push([samples.sample(3, 0).tick, samples.sample(3, 0).world.flags[1]]);
          samples.take(block(24, [[0, 7, 0], [900, 1, 1]]).slice(0, 50)); // cut short: not taken
          samples.take(new ArrayBuffer(3));
          seen.push(samples.sample(3, 0).tick);
          return seen;
        """)
        first, between, last, back, cut = got
        self.assertEqual([round(v, 3) for v in first], [1, 3, 0])
        # Half way; angles by the short way round; what has jumped 9 m is not drawn on its way.
        self.assertAlmostEqual(between[0], 1.5, places=5)
        self.assertAlmostEqual(abs(between[1]), 3.14159, places=3)
        self.assertEqual(between[2], 0)
        self.assertEqual([round(v, 3) for v in last], [2, -3, 9])
        self.assertEqual(back, [20, 0])
        self.assertEqual(cut, 20)

    def test_numbers_on_avatars_can_be_read(self):
        ratios = self.browser.module("""
          const { hue, ink } = await import("/palette.js");
          const light = (c) => { const v = c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; return v; };
          const luminance = (h) => { const n = h.length === 4 ? [...h.slice(1)].map((d) => d + d) : h.slice(1).match(/../g);
            const [r, g, b] = n.map((d) => light(parseInt(d, 16) / 255)); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
          return [...Array(64).keys()].map((slot) => { const [a, b] = [luminance(hue(slot)), luminance(ink(slot))];
            return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); });
        """)
        self.assertGreater(min(ratios), 4.5, ratios)

    def heap(self):
        """MB that are used; more by some while the plots are being drawn."""
        self.browser.driver.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        return self.browser.driver.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"] / 1e6

    def test_an_hour_leaves_the_memory_flat(self):
        b = self.browser
        b.module("""
          const body = { id: 0, shape: "circle", radius: 0.11, mass: 0.4, position: [52, 34], angle: 0 };
          padr.connection.receive(JSON.stringify({ type: "scene", session: 1, name: "pitch", title: "an hour in a minute", seed: 1, slots: 12,
            tick_rate: 60, lower: [0, 0], upper: [105, 68], gravity: [0, 0], avatar: { radius: 0.3, mass: 75, max_speed: 9 },
            spawns: [], bodies: [body], statics: [] }));
        """)
        b.driver.execute_cdp_cmd("HeapProfiler.enable", {})
        sizes = []
        for minute in range(0, 90, 10):
            b.module(HOUR, 600, minute * 60)
            sizes.append(min(self.heap() for _ in range(3)))
        points = b.script("return padr.plots.history.points.length")
        print(f"heap after every ten minutes of a session, MB: {[round(s, 1) for s in sizes]}; {points} points")
        self.assertGreater(points, 2000)
        self.assertLess(points, 3500)
        # An hour is kept; from then on nothing may grow.
        self.assertLess(sizes[-1], sizes[5] * 1.1 + 1)
        self.assertLess(sizes[-1], 60)
        self.check_console(b)


if __name__ == "__main__":
    main()
