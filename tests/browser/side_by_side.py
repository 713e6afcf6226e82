#!/usr/bin/env python3
"""Takes the frames of docs/side-by-side.webp: one peer's picture of the page in two recordings of the same scene, by
`fixed` and by `full`, at the same ticks. tools/pictures.sh records them, calls this, and puts the frames together.

Usage: side_by_side.py PADR_MONITOR PADR_PEER FOLDER FIXED FULL NETWORK
"""

import sys

from browser import *

if len(sys.argv) != 4:
    sys.exit(__doc__)
FIXED, FULL, NETWORK = sys.argv[1:]
PEER = 1  # whose picture
FIRST, LAST, STEP = 20 * 60, 28 * 60, 5  # ticks
WIDTH = 980  # of a frame, pixels
LONGEST_BAR = 30.0  # m

# Everything that is not a picture of the page. The colours are those of the page's dark theme.
FRAME = """
<!doctype html><meta charset="utf-8"><style>
  body { margin: 0; width: 980px; background: #11161c; color: #e8edf2; font: 15px/1.35 "DejaVu Sans", sans-serif; }
  main { display: grid; grid-template-columns: 478px 478px; gap: 8px; padding: 10px 8px 6px; }
  h2 { margin: 0; font-size: 21px; } h2 small { font-size: 15px; font-weight: 400; color: #b7c4d0; margin-left: 8px; }
  img { display: block; width: 478px; margin: 6px 0; border-radius: 4px; }
  .off { display: grid; grid-template-columns: 165px 1fr; align-items: center; font-size: 22px; font-weight: 700; }
  .off i { display: block; height: 14px; border-radius: 3px; }
  #left { color: #ff8ac4; } #left i { background: #ff8ac4; } #right { color: #5fd39a; } #right i { background: #5fd39a; }
  p { margin: 0; padding: 2px 8px 9px; color: #b7c4d0; text-align: center; }
  b { color: #ff6fb5; }
</style>
<main>
  <section><h2>fixed <small>authority and one threshold of 0.5 m</small></h2><img><div class="off" id="left"><span></span><i></i></div></section>
  <section><h2>full <small>what comes late is replayed</small></h2><img><div class="off" id="right"><span></span><i></i></div></section>
</main>
<p>Same players, same network: NETWORK. What one of four peers sees. <b>Pink</b>: where things really are.</p>
"""

# The canvas of the peer at a tick that has been sought, and the peer's inconsistency then; null while it is not there.
LOOK = """
  const [peer, tick] = arguments, s = padr.session;
  const there = (view) => s.samples.sample(view === 4 ? 255 : peer, view)?.tick === tick;
  if (s.timeline.tick !== tick || s.timeline.playing || !there(0) || !there(4)) return null;
  padr.views.draw();
  const off = padr.plots.history.points.map((p) => p.peers.get(peer)).filter((p) => p && p.combined_m !== null);
  const nearest = off.reduce((a, b) => (Math.abs(b.at_tick - tick) < Math.abs(a.at_tick - tick) ? b : a));
  return [padr.views.tiles.get(peer).canvas.toDataURL(), nearest.combined_m];
"""

SHOW = """
  const [images, off, longest] = arguments;
  document.querySelectorAll(".off").forEach((line, i) => {
    line.querySelector("span").textContent = `${off[i].toFixed(1)} m off`;
    line.querySelector("i").style.width = `${Math.min(100, (100 * off[i]) / longest)}%`;
  });
  return Promise.all([...document.images].map((image, i) => { image.src = images[i]; return image.decode(); })).then(() => document.body.scrollHeight);
"""


def open_recording(folder):
    monitor = Monitor("--trace", folder)
    page = Browser(502, 900, dark=True)
    page.resize(502, 900, scale=2)
    page.open(monitor.address)
    wait(lambda: page.script("return padr.session.timeline && padr.session.present().length"), "the recording")
    page.script("padr.connection.send({ type: 'halt' })")
    page.script("padr.views.onAction('large', arguments[0])", PEER)
    return monitor, page


def take():
    recordings = [open_recording(FIXED), open_recording(FULL)]
    frame = Browser(WIDTH, 500)
    try:
        frame.driver.get("about:blank")
        frame.script("document.open(); document.write(arguments[0]); document.close()", FRAME.replace("NETWORK", NETWORK))
        for tick in range(FIRST, LAST, STEP):
            looks = []
            for _, page in recordings:
                page.script("padr.connection.send({ type: 'seek', tick: arguments[0] })", tick)
                looks.append(wait(lambda: page.script(LOOK, PEER, tick), f"tick {tick}"))
            height = frame.script(SHOW, [look[0] for look in looks], [look[1] for look in looks], LONGEST_BAR)
            frame.resize(WIDTH, height)
            frame.picture(f"frame-{(tick - FIRST) // STEP:03}")
    finally:
        frame.close()
        for monitor, page in recordings:
            page.close()
            monitor.end()


if __name__ == "__main__":
    take()
