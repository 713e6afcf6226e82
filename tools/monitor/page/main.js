// Puts the page together: what comes from padr-monitor goes to those who show it, once for each frame of the screen.

import { Camera } from "./camera.js";
import { Connection } from "./connection.js";
import { Driver } from "./drive.js";
import { Events } from "./events.js";
import { howToDriveOn, intro, WHAT_PICTURES_ARE } from "./intro.js";
import { Knobs } from "./knobs.js";
import { Meter } from "./meter.js";
import { momentOf, readMoment } from "./moment.js";
import { Orders } from "./orders.js";
import { Plots } from "./plots.js";
import { Pointers } from "./pointers.js";
import { Replay } from "./replay.js";
import { VIEW_NAMES } from "./samples.js";
import { Session } from "./session.js";
import { shownSample, Stories, wantedSample } from "./stories.js";
import { setText, Tables } from "./table.js";
import { Theme } from "./theme.js";
import { Tour } from "./tour.js";
import { Views } from "./views.js";

const OVER = "The session is over.";
const RATE = 20; // views a second that are asked for
const $ = (selector) => document.querySelector(selector);

const session = new Session();
const camera = new Camera();
const theme = new Theme($("#theme"));
const events = new Events($("#events"), $("#every-event"), session);
const views = new Views($("#views"), session, camera, theme);
const plots = new Plots($("#plots"), session, theme, events);
const tables = new Tables($("#peers"), $("#links"), $("#verdict"), $("#details ul"));
const meter = new Meter($("#frame-time"));
const stories = new Stories($("#stories"));

let ended = false; // the program has said goodbye and is not back
const connection = new Connection({
  open() {
    ended = false;
    session.offline = null;
    complain(null);
    subscribe();
  },
  lost(saidGoodbye) {
    ended ||= saidGoodbye;
    session.offline = ended ? "padr-monitor has ended" : "not connected";
    driver.forget(null);
    session.stand();
    replay.update();
    if (ended) {
      tour.forget();
      complain(endInWords(), true);
    } else {
      complain("The connection to padr-monitor was lost. Trying again …");
    }
    refresh();
  },
  hello(hello) {
    session.hello = hello;
    document.body.dataset.mode = hello.mode;
    stories.begin(hello);
    const wanted = wantedSample();
    if (wanted !== null && wanted !== hello.sample) complain(`There is no story called “${wanted}”. The list below has all.`);
    else complain(null);
    token();
    knobs.begin();
    subscribe();
    refresh();
  },
  scene(scene) {
    const same = session.scene?.session === scene.session && session.scene?.name === scene.name; // told again after the connection was lost
    session.begin(scene);
    camera.setArea({ x: scene.lower[0], y: scene.lower[1] }, { x: scene.upper[0], y: scene.upper[1] });
    views.forgetBackgrounds();
    plots.begin();
    events.begin();
    drivenOnce = null; // the program forgets its path, too
    driver.forget(null);
    if (!same) tour.forget();
    refresh();
  },
  history(message) {
    for (const point of message.points) plots.add(point);
  },
  peers(message) {
    session.offline = null;
    session.takePeers(message);
    if (driver.slot !== null && !session.controllable().some((p) => p.slot === driver.slot)) driver.forget(`Peer ${driver.slot} is not there any more.`);
    if (camera.follow !== null && !session.present().some((p) => p.slot === camera.follow)) camera.follow = null;
    endTourWithoutPeers();
    tour.resume();
    refresh();
  },
  series(point) {
    session.takePoint(point);
    // A recording that stands sends no table after its point.
    if (session.replayed()) tables.update(session);
    else plots.add(point);
  },
  events(message) {
    events.add(message.events);
  },
  timeline(message) {
    session.takeTimeline(message);
    replay.update();
    openMoment();
  },
  taken(message) {
    driver.taken(message.peer);
  },
  refused(answer) {
    complain(answer.text);
  },
  binary(buffer) {
    meter.received(buffer.byteLength);
    session.samples.take(buffer);
  },
}, wantedSample());

const orders = new Orders(connection, session);
const driver = new Driver(connection, session);
const pointers = new Pointers(views, camera, driver);
const knobs = new Knobs($("#knobs"), session, orders);
const replay = new Replay($("#replay"), connection, session);
const tour = new Tour($("#tour"), session, orders);

// Kept: what the address ends with changes.
let secret = null;
function token() {
  secret = readMoment(location.hash).token ?? secret;
  if (secret && session.hello?.needs_token) connection.send({ type: "token", token: secret });
}

/** What the address says of a moment is shown once, when the recording is there. */
let opened = false;
function openMoment() {
  if (opened || !session.replayed()) return;
  opened = true;
  const moment = readMoment(location.hash);
  if (moment.tick === null) return;
  connection.send({ type: "halt" });
  replay.seek(moment.tick);
  if (moment.show) setMode(moment.show, moment.peer);
  if (moment.camera) camera.show(...moment.camera);
  camera.follow = moment.follow;
  plots.select(moment.plots);
}
addEventListener("hashchange", () => {
  opened = false;
  token();
  openMoment();
});

function subscribe() {
  const wanted = VIEW_NAMES.filter((name) => name === "shown" || views.ghosts[name] || (name === "authority" && views.mode === "overlay") || (name === "confirmed" && session.hello?.mode === "capture"));
  connection.send({ type: "subscribe", views: wanted, rate: RATE });
}

/** `calm`: nothing has gone wrong. */
function complain(text, calm = false) {
  $("#error").hidden = !text;
  $("#error").classList.toggle("calm", calm);
  setText($("#error"), text ?? "");
}

function endInWords() {
  if (session.replayed()) return "padr-monitor, the program that plays this recording, has ended, so the recording stands still. Start it again at the same port to go on.";
  if (session.over()) return OVER;
  const peers = session.present().length > 0 ? "; the peers may play on" : "";
  return `padr-monitor has ended${peers}. Start it again at the same port to go on.`;
}

/** The tour needs somebody who takes its orders. */
function endTourWithoutPeers() {
  if (tour.step === null || session.controllable().length > 0) return;
  tour.forget();
  if (session.present().length > 0) complain("The tour has ended, because no peer takes orders any more.");
}

/** Everything that is not drawn for each frame. */
function refresh() {
  tables.update(session);
  knobs.update();
  replay.update();
  const { hello, scene } = session;
  if (hello || session.offline) setText($("#state"), stateInWords(hello));
  setText($("#session"), scene ? ` of session ${scene.session}` : "");
  const there = session.present().length;
  const nobody = !(scene && (there > 0 || hello?.mode === "capture"));
  // The stories stand in for peers until there are some.
  const alone = nobody && hello?.mode === "live" && !session.over();
  if (alone !== document.body.classList.contains("empty")) $("#stories").open = alone;
  document.body.classList.toggle("empty", alone);
  $("#empty").hidden = !nobody;
  if (nobody) setText($("#empty"), hello ? emptyInWords(hello) : "");
  $("#tour-button").hidden = $("#knobs").hidden = session.replayed();
  $("main").classList.toggle("alone", session.replayed());
  setText($("#plots-head"), session.replayed() ? "Over time" : "As it happens");
  introduce();
  $("#tour-button").disabled = session.controllable().length === 0 || session.waits();
  hint();
  views.update(); // last: pictures have the room that the rest leaves
}

function introduce() {
  const { hello, scene } = session;
  const sample = shownSample(hello);
  setText($("#title"), sample ? `${sample.title}.` : scene ? `${scene.title}.` : "");
  setText($("#intro .text"), sample ? `${sample.about} ${WHAT_PICTURES_ARE}` : intro(session));
  $("#intro .note").hidden = !sample;
  setText($("#intro .made"), sample ? hello.source : "");
  setText($("#intro .live"), sample ? sample.live : "");
}

function stateInWords(hello) {
  if (session.offline) return session.offline;
  if (hello.sample) return "recording";
  if (hello.mode !== "live") return `recording: ${hello.source}`;
  const { time } = session.peers;
  if (!session.scene || time === undefined || time === null) return `waiting for peers at ${hello.source}`;
  const count = session.peers.other_sessions;
  const others = count > 0 ? `, ${count} other session${count > 1 ? "s" : ""}` : "";
  const now = session.over() ? "over" : session.waits() ? "waiting for more peers" : "live";
  return `${now}, ${Math.floor(time / 60)}:${String(Math.floor(time % 60)).padStart(2, "0")}${others}`;
}

function emptyInWords(hello) {
  if (session.over()) return OVER;
  if (hello.mode !== "live") return "Reading the recording …";
  return `This page shows every peer of a session side by side. No peer is here yet.\nStart four with tools/demo.sh, or two by hand:\npadr-peer --listen 127.0.0.1:7001 --monitor ${hello.source} --control\npadr-peer --join 127.0.0.1:7001 --monitor ${hello.source} --control\nOr watch a story, which needs no peer.`;
}

let said = null;
function hint() {
  const element = $("#hint");
  element.classList.toggle("on", driver.slot !== null);
  setText(element, driver.slot !== null ? howToDriveOn(driver.slot) : said ?? "");
  saveLink();
}

/** A link to what was driven, as a path for --input. */
let drivenOnce = null;
function saveLink() {
  if (driver.slot !== null) drivenOnce = driver.slot;
  const link = $("#save");
  link.hidden = drivenOnce === null || driver.slot !== null;
  if (link.hidden) return;
  link.href = `/api/path?peer=${drivenOnce}`;
  link.download = `path-${drivenOnce}.csv`;
  setText(link, `Save the path that avatar ${drivenOnce} was driven (CSV, for --input path:FILE)`);
}

driver.changed = (why) => {
  said = why;
  views.driven = driver.slot;
  if (driver.slot !== null) views.tiles.get(driver.slot)?.canvas.focus({ preventScroll: true });
  refresh();
};
// Keys shall steer again after a knob was turned by mouse; who turns knobs by keys stays at the knob.
let byPointer = false;
document.addEventListener("pointerdown", () => { byPointer = true; }, true);
document.addEventListener("keydown", () => { byPointer = false; }, true);
document.addEventListener("change", (e) => {
  if (driver.slot !== null && byPointer && !e.target.matches("input:not([type])")) views.tiles.get(driver.slot)?.canvas.focus({ preventScroll: true });
});
function toggleDriving(slot) {
  if (driver.slot === slot) return;
  if (session.drivable().some((p) => p.slot === slot)) driver.start(slot);
  else tellWhyNot(slot);
}

/** Who clicks a picture to drive learns why nothing happens. */
function tellWhyNot(slot) {
  const peer = session.peer(slot);
  if (!peer || session.replayed() || session.offline) return;
  said = !session.mayControl() ? "This page may only look."
    : peer.input === "none" ? `Peer ${slot} is a spectator: it has no avatar to drive.`
      : !peer.controllable ? `Peer ${slot} takes no orders, as it was started without --control.`
        : session.waits() ? "Nobody can drive before play begins."
          : said;
  hint();
}
pointers.clicked = (slot) => {
  if (views.mode === "side") views.large = slot;
  toggleDriving(slot);
  views.layOut();
};
views.onTile = (tile) => pointers.watch(tile);
views.onAction = (action, slot) => {
  if (action === "drive" && driver.slot === slot) driver.release();
  else if (action === "drive") toggleDriving(slot);
  else if (action === "follow") camera.follow = camera.follow === slot ? null : slot;
  else setMode(views.mode === "one" ? "side" : "one", slot);
  if (action === "follow" && camera.follow !== null && camera.zoom < 1.5) camera.zoom = 2.5;
  refresh();
};

function setMode(mode, slot = null) {
  views.mode = mode;
  views.large = slot;
  subscribe();
  for (const b of document.querySelectorAll("button[data-mode]")) b.setAttribute("aria-pressed", b.dataset.mode === mode);
  // Overlaid, errors are all that is drawn.
  for (const box of document.querySelectorAll("[id^='ghost-']")) box.disabled = mode === "overlay";
  refresh();
}
for (const b of document.querySelectorAll("button[data-mode]")) b.addEventListener("click", () => setMode(b.dataset.mode));
$("#closer").addEventListener("click", () => camera.zoomAbout(camera, 1.4));
$("#farther").addEventListener("click", () => camera.zoomAbout(camera, 1 / 1.4));
$("#reset").addEventListener("click", () => { camera.reset(); refresh(); });
for (const name of ["authority", "predicted", "confirmed"]) {
  $(`#ghost-${name}`).addEventListener("change", (e) => {
    views.ghosts[name] = e.target.checked;
    subscribe();
  });
}

function markSpan() {
  for (const b of document.querySelectorAll("[data-span]")) {
    const span = b.dataset.span === "all" ? Infinity : Number(b.dataset.span);
    // A recording is shown whole where no part of it is selected.
    b.setAttribute("aria-pressed", plots.selected === null && (session.replayed() ? Infinity : plots.span) === span);
  }
}
for (const b of document.querySelectorAll("[data-span]")) {
  b.addEventListener("click", () => plots.follow(b.dataset.span === "all" ? Infinity : Number(b.dataset.span)));
}
plots.selectionChanged = markSpan;
plots.sought = (time) => session.replayed() && replay.seek(Math.round(time * 60));
replay.failed = complain;
replay.shared = () => `${location.origin}${location.pathname}${location.search}${momentOf(session, views, camera, plots)}`;
theme.changed = () => {
  views.recolour();
  plots.recolour();
};
$("#tour-button").addEventListener("click", () => tour.start());
tour.onMove = () => {
  document.body.classList.toggle("touring", tour.step !== null);
  document.body.dataset.spot = tour.spot();
  scrollTo(0, 0);
  views.layOut();
};
tour.left = () => $("#tour-button").focus({ preventScroll: true });
// What a step of the tour speaks of stands below the pictures.
views.reserved = () => document.querySelector({ plots: "#plots-part", table: "#table-part", events: "#plots-part" }[document.body.dataset.spot])?.offsetHeight ?? 0;
const low = matchMedia("(min-width: 601px) and (max-height: 620px)"); // as style.css has it
views.beside = () => low.matches && tour.step !== null;
tour.restored = (refused) => complain(refused.length > 0 ? `Not everything could be restored: ${refused[0].text}` : null);
setInterval(() => events.show(), 500);
setInterval(() => {
  for (const [slot, tile] of views.tiles) views.describe(slot, tile);
}, 250);

let before = performance.now();
function frame(now) {
  requestAnimationFrame(frame); // first: what fails in one frame shall not end all
  const began = performance.now();
  driver.tick();
  session.samples.advance(Math.min(now - before, 250) / 1000, session.speed());
  views.draw();
  meter.frame(now, now - before, performance.now() - began);
  before = now;
}
requestAnimationFrame(frame);
refresh();

window.padr = { session, camera, views, plots, driver, connection, tour, events, stats: meter.stats };
