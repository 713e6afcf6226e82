// A comparison that a person takes: two recordings side by side that differ in `--convergence` alone, unnamed, and each way as often on
// the left as on the right. The answers stay in the page until they are saved.

import { Camera } from "./camera.js";
import { Connection } from "./connection.js";
import { Session } from "./session.js";
import { Theme } from "./theme.js";
import { Views } from "./views.js";

const METHODS = ["pvb", "track"]; // each has a sample of its own, shown-NAME
const ROUNDS = 8; // even, so that sides come out even
const FIRST = 60; // tick of the earliest moment
const ZOOM = 1.6; // about the player's own avatar
const RATE = 60; // views a second: every step
const BUTTONS = 90; // pixels of what stands below the pictures
const COLUMNS = ["round", "time", "recording", "peer", "from_tick", "to_tick", "left", "right", "answer", "chosen", "times_seen", "revision"];
const $ = (selector) => document.querySelector(selector);

/** 0 .. n - 1 */
function below(n) {
  return crypto.getRandomValues(new Uint32Array(1))[0] % n;
}

function shuffled(all) {
  const list = [...all];
  for (let i = list.length - 1; i > 0; --i) {
    const k = below(i + 1);
    [list[i], list[k]] = [list[k], list[i]];
  }
  return list;
}

/** One of the two recordings, and its picture. */
class Take {
  constructor(method, theme) {
    this.method = method;
    this.session = new Session();
    this.camera = new Camera();
    this.grid = document.createElement("div");
    this.grid.className = "take";
    this.views = new Views(this.grid, this.session, this.camera, theme);
    this.views.mode = "one";
    this.views.reserved = () => BUTTONS;
    this.views.ghosts.authority = false; // errors would tell more than a player sees
    this.connection = new Connection({
      open: () => this.connection.send({ type: "subscribe", views: ["shown"], rate: RATE }),
      lost: () => complain("The connection to padr-monitor was lost. Load the page again."),
      hello: (hello) => { this.session.hello = hello; },
      scene: (scene) => {
        this.session.begin(scene);
        this.camera.setArea({ x: scene.lower[0], y: scene.lower[1] }, { x: scene.upper[0], y: scene.upper[1] });
      },
      peers: (message) => {
        this.session.takePeers(message);
        this.views.update();
      },
      timeline: (message) => this.session.takeTimeline(message),
      binary: (buffer) => this.session.samples.take(buffer),
    }, `shown-${method}`);
  }

  ready() {
    return this.session.hello !== null && this.session.timeline !== null && this.session.present().length > 0;
  }

  look(peer) {
    this.views.large = peer;
    this.camera.reset();
    this.camera.zoom = ZOOM;
    this.camera.follow = peer;
    this.views.update();
  }

  reached(tick) {
    return this.session.timeline.tick >= tick;
  }
}

class Blind {
  constructor(takes) {
    this.takes = takes;
    this.seconds = 6; // of a moment
    this.answers = [];
    this.times = 0; // that something was played
    this.focused = false; // a button that was disabled had the focus
    // Which method is on the left: as often the one as the other.
    this.lefts = shuffled(Array.from({ length: ROUNDS }, (_, i) => METHODS[i % 2]));
    for (const b of document.querySelectorAll("[data-answer]")) b.addEventListener("click", () => this.answer(b.dataset.answer));
    $("#again").addEventListener("click", () => this.play());
    document.addEventListener("visibilitychange", () => this.interrupt());
    this.enable(false);
  }

  take(method) {
    return this.takes.find((t) => t.method === method);
  }

  /** Another moment, of another player. */
  begin() {
    const { session } = this.takes[0];
    const long = this.seconds * 60;
    const from = FIRST + below(session.timeline.last - FIRST - long);
    const left = this.lefts[this.answers.length];
    const right = METHODS.find((m) => m !== left);
    const peers = session.present();
    this.round = { left, right, from, to: from + long, peer: peers[below(peers.length)].slot, seen: 0 };
    $("#left").append(this.take(left).grid);
    $("#right").append(this.take(right).grid);
    this.take(left).views.called = "Left: ";
    this.take(right).views.called = "Right: ";
    for (const t of this.takes) t.look(this.round.peer);
    this.play();
  }

  async play() {
    const { round } = this;
    const time = ++this.times; // another one begins when this one is interrupted
    this.enable(false);
    const number = `Round ${this.answers.length + 1} of ${ROUNDS}`;
    say(`${number}: as player ${round.peer} saw it`);
    for (const message of [{ type: "halt" }, { type: "seek", tick: round.from }, { type: "play" }]) {
      await this.all(message);
      if (time !== this.times) return;
    }
    await new Promise((done) => { this.shown = done; });
    await this.all({ type: "halt" });
    if (time !== this.times) return;
    ++round.seen;
    say(`${number}: which looked right? Answer below, or show it again`);
    this.enable(true);
  }

  /** What is played while nobody sees it does not count: it halts, and begins anew when the page is seen again. */
  interrupt() {
    if (!this.round || !this.playing) return;
    this.shown = null;
    if (!document.hidden) {
      this.play();
      return;
    }
    ++this.times;
    this.all({ type: "halt" });
  }

  async all(message) {
    const answers = await Promise.all(this.takes.map((t) => t.connection.ask(message)));
    const wrong = answers.find((a) => !a.ok);
    if (wrong) complain(wrong.text);
  }

  /** Once for each frame. */
  look() {
    if (this.round && this.shown && this.takes.every((t) => t.reached(this.round.to))) {
      this.shown();
      this.shown = null;
    }
  }

  /** The buttons; the keyboard's focus, which a button loses that is disabled, is on the first one again afterwards. */
  enable(on) {
    const buttons = [...document.querySelectorAll("[data-answer], #again")];
    this.focused ||= buttons.includes(document.activeElement);
    for (const b of buttons) b.disabled = !on;
    this.playing = !on;
    if (!on || !this.focused) return;
    this.focused = false;
    buttons[0].focus();
  }

  answer(answer) {
    const { round } = this;
    const { hello } = this.takes[0].session;
    this.answers.push({
      round: this.answers.length + 1, time: new Date().toISOString(), recording: this.take("track").session.scene.name, peer: round.peer,
      from_tick: round.from, to_tick: round.to, left: round.left, right: round.right, answer,
      chosen: answer === "none" ? "none" : round[answer], times_seen: round.seen, revision: hello.revision,
    });
    this.offer();
    if (this.answers.length < ROUNDS) this.begin();
    else this.end();
  }

  csv() {
    return [COLUMNS, ...this.answers.map((a) => COLUMNS.map((c) => a[c]))].map((row) => `${row.join(",")}\n`).join("");
  }

  offer() {
    const link = $("#answers");
    if (link.href) URL.revokeObjectURL(link.href);
    link.href = URL.createObjectURL(new Blob([this.csv()], { type: "text/csv" }));
    link.hidden = false;
  }

  end() {
    this.enable(false);
    this.round = null;
    if (this.focused) $("#answers").focus();
    const count = (what) => this.answers.filter((a) => a.chosen === what).length;
    say("All rounds are over.");
    $("#result").textContent = `You chose ${METHODS.map((m) => `${m} ${count(m)} times`).join(", ")}, and saw no difference ${count("none")} times.`;
  }
}

function say(text) {
  $("#state").textContent = text;
}

function complain(text) {
  $("#error").hidden = false;
  $("#error").textContent = text;
}

const theme = new Theme($("#theme"));
const takes = METHODS.map((m) => new Take(m, theme));
const blind = new Blind(takes);
theme.changed = () => takes.forEach((t) => t.views.recolour());

let before = performance.now();
let began = false;
function frame(now) {
  for (const t of takes) {
    t.session.samples.advance(Math.min(now - before, 250) / 1000, t.session.speed());
    t.views.draw();
  }
  before = now;
  if (!began && takes.every((t) => t.ready())) {
    began = true;
    blind.begin();
  }
  blind.look();
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);

window.padr = { blind, takes };
