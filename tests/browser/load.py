#!/usr/bin/env python3
"""What drawing costs: 4 peers with 200 bodies, and 12 peers on the pitch. See browser.py.

Peers, monitor and a browser without a graphics card share the processors here, so the numbers are printed and held to no limit.
"""

from browser import *


class Load(Case):
    def measure(self, name, count, *arguments):
        monitor = Monitor()
        self.addCleanup(monitor.end)
        own = [["--input", f"wander:{i}"] for i in range(count)]
        session = Session(monitor, count, "--netem", "delay 30ms 5ms", *arguments, own=own)
        self.addCleanup(session.end)
        b = Browser()
        self.addCleanup(b.close)
        b.open(monitor.address)
        self.wait_for_peers(b, count)
        time.sleep(12)
        stats = b.script("return padr.stats")
        b.picture(f"load-{name}")
        print(f"{name}: {stats['fps']:.0f} frames/s; in a frame {stats['frame_ms']:.1f} ms mean, {stats['frame_ms_p95']:.1f} ms p95; "
              f"{stats['bytes'] / stats['messages'] / 1000:.1f} kB a message")  # fmt: skip
        self.assertGreater(stats["frames"], 0)
        self.check_console(b)

    def test_4_peers_and_200_bodies(self):
        self.measure("clutter", 4, "--scenario", "clutter")

    def test_12_peers_on_the_pitch(self):
        self.measure("pitch", 12, "--scenario", "pitch")


if __name__ == "__main__":
    main()
