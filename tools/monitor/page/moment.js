// A moment of a recording as the end of an address: tick, view, camera and the span of the plots that is selected. Who
// opens the address sees the same.
//
//   #tick=742&show=one&peer=1&camera=10.5,7,2.5&plots=8,14.5

const SHOWS = ["side", "overlay", "one"];

/** The end of the address for what is seen now. */
export function momentOf(session, views, camera, plots) {
  const said = new URLSearchParams({ tick: session.timeline.tick, show: views.mode });
  if (views.mode === "one") said.set("peer", views.slots()[0]);
  if (camera.follow !== null) said.set("follow", camera.follow);
  if (camera.zoom !== 1 || camera.follow !== null) said.set("camera", [camera.x, camera.y, camera.zoom].map(short).join());
  if (plots.selected) said.set("plots", plots.selected.map(short).join());
  return `#${said.toString().replaceAll("%2C", ",")}`;
}

/** What such an end says; fields that it lacks, or that are wrong, are null. The tick tells whether it is one at all. */
export function readMoment(hash) {
  // A "+" is one, not a blank: tokens may have some.
  const said = new URLSearchParams(hash.slice(1).replaceAll("+", "%2B"));
  const whole = (name) => (/^\d{1,9}$/.test(said.get(name) ?? "") ? Number(said.get(name)) : null);
  const numbers = (name, count) => {
    const values = (said.get(name) ?? "").split(",").map((v) => (v === "" ? NaN : Number(v)));
    return values.length === count && values.every(Number.isFinite) ? values : null;
  };
  return {
    tick: whole("tick"),
    show: SHOWS.includes(said.get("show")) ? said.get("show") : null,
    peer: whole("peer"),
    follow: whole("follow"),
    camera: numbers("camera", 3),
    plots: numbers("plots", 2),
    token: said.get("token"),
  };
}

function short(v) {
  return Math.round(v * 1000) / 1000;
}
