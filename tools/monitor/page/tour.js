// The tour: nine steps that set the knobs, say what to look for, and leave everything as it was found.

import { howToDrive } from "./intro.js";
import { together } from "./knobs.js";

const FAST = "delay 20ms 3ms";
const SLOW = "delay 200ms 40ms loss 5%";
const WITHOUT = "avatar-only"; // the technique without authority: a session keeps to it, or to the others
const KEPT = "padr-tour"; // in the tab's storage
const THINGS = { ball: "the ball", dominoes: "the first domino", van: "the van" }; // what the paths of the scenes stop short of

const CLAIMS_NOTHING = "This session is without authority, so nobody claims anything: things stay grey. A session with it is the story “Collision by proxy”.";

// `spot`: the part of the page that a step speaks of besides the pictures; it is shown below them. `set` gets the Orders,
// the session and which half; it sets all that the step needs, as steps can be gone back too.
const STEPS = [
  {
    title: "What you see",
    text: (s) => `${s.players().length} programs play in one world, and none of them is a server. Each picture is the world as one of them sees it. `
      + "Discs with numbers are avatars, each moved by its own program; everything else obeys physics. "
      + "The pictures should be the same. Where one is wrong, a line leads from what it shows to where the thing really is.",
    look: "Pick one thing and find it in every picture. The figure under each picture says how wrong it is, all things together.",
    spot: "plots",
    technique: "full",
    set: (o, s) => begin(o, s, FAST, "full"),
  },
  {
    title: "No authority",
    text: () => "Somebody has to know where a thing is. The button cuts all links for two seconds and a half. Meanwhile each peer plays on by itself, and nobody's word counts for the others. (A whole session without authority is the story “Stopping short”.)",
    look: "Avatars walk on in straight lines or stand in the others' pictures, and what they push moves in one picture only. Lines grow. By how much nobody can tell while worlds are apart: captions say “error not known”, and the inconsistency plot has a gap. It is high right after that, and then falls.",
    spot: "plots",
    technique: "fixed",
    set: (o, s) => begin(o, s, FAST, "fixed"),
    // Somebody reads five lines first, and peers that are cut off for 3 s give each other up.
    sign: "Cut all links for 2.5 s",
    act: (o, s) => everybody(s).map((slot) => o.cut(slot, "all", 2.5)),
  },
  {
    title: "Dynamic authority",
    text: (s) => without(s) ? CLAIMS_NOTHING : "Now the peer whose avatar touches a thing decides about it, at once and without asking. The thing takes that avatar's colour in every picture. Nobody decides about grey things: they lie still or move by physics alone, the same everywhere.",
    look: () => `Drive an avatar into some things: ${howToDrive()}. They take its colour, and go grey again once they rest.`,
    technique: "full",
    set: (o, s) => begin(o, s, FAST, "full"),
  },
  {
    title: "The threshold",
    text: (s) => "A peer does not tell where its avatar is at every step. The others go on by what they know, and the peer tells them again when they are wrong by more than the threshold, the dashed circle. "
      + `It is 1.5 m for ${peersInWords(everybody(s), 0)} now${everybody(s).length > 1 ? `, and 0.1 m for ${peersInWords(everybody(s), 1)}` : ""}.`,
    look: "Wide circles: avatars jump or slide in the other pictures, and few updates are sent. Narrow ones: smooth motion, more updates (the column “updates” of the table). With the adaptive technique the circle shrinks by itself, with a red “!”, when a contact is coming.",
    spot: "table",
    technique: "fixed",
    set: (o, s) => [...begin(o, s, FAST, "fixed"), ...everybody(s).map((slot, i) => o.knob(slot, "threshold", i % 2 ? "0.1" : "1.5"))],
  },
  {
    title: "Stopping short",
    text: (s) => `${runner(s)} stops just short of it. Only its own picture knows that at once. In the others its model runs on until it is wrong by 0.8 m. `
      + (without(s)
        ? "Nobody has authority here, so the model pushes what it meets. In the other pictures a thing moves that nobody has touched, and nothing puts that right."
        : "The model runs into the thing and moves nothing. A model may push a thing only after the owner of the avatar has told of a contact. (Without authority a model pushes things at once: see the story “Stopping short”.)"),
    look: (half, s) => (without(s)
      ? "Compare peer 0's picture with the others: lines lead from what they show to where things really are."
      : "In the other pictures the avatar's line grows to 0.8 m and is gone. No thing gets a line."),
    technique: "fixed",
    set: (o, s) => [...begin(o, s, FAST, "fixed"), o.knob("all", "threshold", "0.8")],
  },
  {
    title: "What a predictor sees",
    text: (s, half) => (half === 0
      ? `The threshold is 0.8 m, and 0.3 m while a contact is predicted. Look-ahead predicts now: it plays on from where the avatar truly is. ${runner(s)} stops in time, so there is no contact: look-ahead is blind to a stop short.`
      : "Now PCC predicts. It plays on twice, from where the avatar is and from where its model is, and compares what becomes of things. The model would hit what the avatar does not: the threshold is 0.3 m in time, and the model is put right before it gets there."),
    look: (half) => (half === 0
      ? "The dashed circle stays wide while the avatar runs at the thing and stops. Then press “PCC”."
      : "A red “!”, and the circle shrinks before the avatar has stopped."),
    technique: "adaptive",
    set: (o, s, half) => [...begin(o, s, FAST, "adaptive"), o.knob("all", "threshold", "0.8:0.3"), o.knob("all", "predictor", half === 0 ? "lookahead" : "pcc")],
    halves: ["Look-ahead", "PCC"],
  },
  {
    title: "The chain by proxy",
    text: (s, half) => (without(s)
      ? CLAIMS_NOTHING
      : half === 0
        ? "An avatar touches A, A touches B, B touches C. The owner of the avatar decides about all three: it claims them and sends their states. When the chain breaks, it sends their exact states once more."
        : "Now only what the avatar itself touches is claimed and told. B and C are nobody's: in the other pictures they go where the avatar's model, not the avatar, has sent them."),
    look: (half) => (half === 0
      ? "Drive an avatar into a thing so that it pushes another (the story “Collision by proxy” has three in a row): all take the avatar's colour."
      : "Push some things again: only the first takes the avatar's colour, and lines lead from the others."),
    technique: "adaptive",
    set: (o, s, half) => [...begin(o, s, FAST, "adaptive"), o.knob("all", "proxy-update", half === 0 ? "on" : "off")],
    halves: ["With proxy updates", "Without"],
  },
  {
    title: "Latency, without and with replay",
    text: (s, half) => (half === 0
      ? "Now the network is slow: 200 ms one way, and 5 % is lost. What arrives is applied as if it were true at that moment, though it is old by then."
      : "The same network, with replay: each update is put where it belongs, in the past, and everything since is played again. Even things that nobody told about are then right."),
    look: (half) => (half === 0
      ? "Things end up in different places, and stay there: inconsistency does not go back to zero when all rests. Then press “With replay”."
      : "Within a second the lines at things are gone; what is left are avatars that changed their minds less than 200 ms ago. Confirmed worlds: identical."),
    spot: "plots",
    technique: (half) => (half === 0 ? "adaptive" : "full"),
    set: (o, s, half) => begin(o, s, SLOW, half === 0 ? "adaptive" : "full"),
    halves: ["Without replay", "With replay"],
  },
  {
    title: "A partition",
    text: (s) => `Peer ${last(s)} is cut off from all others for 5 s. After three seconds the others give it up: its avatar goes, and its things are free. When the network is whole again it comes back by itself, as a new life. Until then each side confirms a world of its own: the top says “↮ apart”, until some seconds after the cut.`,
    look: "Its picture goes its own way, then jumps to the others' world. See the events, and at the top that confirmed worlds are identical again.",
    spot: "events",
    technique: "full",
    set: (o, s) => [...begin(o, s, FAST, "full"), o.cut(last(s), "all", 5)],
    sign: "Again",
    act: (o, s) => [...begin(o, s, FAST, "full"), o.cut(last(s), "all", 5)],
  },
];

function begin(orders, session, network, technique) {
  return [orders.netem("all", "all", network), orders.knob("all", "technique", without(session) ? WITHOUT : technique)];
}

function without(session) {
  return session.present().some((p) => p.technique === WITHOUT);
}

/** Who stops short: in a scene an avatar on a path, elsewhere whoever is driven. */
function runner(session) {
  const thing = THINGS[session.scene?.name];
  const onPath = session.present().find((p) => p.input.startsWith("path:"));
  if (thing && onPath) return `Time after time avatar ${onPath.slot} runs at ${thing}. It`;
  return `Drive an avatar straight at a thing (${howToDrive()}), and let go just before. It`;
}

function everybody(session) {
  return session.drivable().map((p) => p.slot);
}

function last(session) {
  return everybody(session).at(-1);
}

/** Every second of these peers, from the `first` on. */
function peersInWords(slots, first) {
  const chosen = slots.filter((_, i) => i % 2 === first);
  return chosen.length === 1 ? `peer ${chosen[0]}` : `peers ${chosen.slice(0, -1).join(", ")} and ${chosen.at(-1)}`;
}

export class Tour {
  constructor(panel, session, orders) {
    this.panel = panel;
    this.session = session;
    this.orders = orders;
    this.step = null;
    this.half = 0;
    this.onMove = () => {};
    const on = (name, act) => panel.querySelector(`.${name}`).addEventListener("click", () => this.unlessOffline(act));
    on("back", () => this.go(this.step - 1));
    on("next", () => this.go(this.step + 1));
    on("again", () => this.give(STEPS[this.step].act));
    on("half", () => {
      this.half = 1 - this.half;
      this.show();
      this.set();
    });
    on("end", () => this.end());
    panel.addEventListener("keydown", (e) => {
      if (e.code === "Escape") this.unlessOffline(() => this.end());
    });
  }

  /** What a step sets, and what its end restores, somebody has to hear. */
  unlessOffline(act) {
    if (this.session.offline) this.complain([{ text: `${this.session.offline}: the tour goes on when padr-monitor is back` }]);
    else act();
  }

  /** Which part of the page is spoken of now; empty: the pictures alone, or no tour. */
  spot() {
    return STEPS[this.step]?.spot ?? "";
  }

  start() {
    if (this.step !== null) return;
    this.before = this.orders.remember();
    this.panel.hidden = false;
    this.go(0);
    this.panel.focus();
  }

  /** Goes on where this tab was when its page was loaded again; peers have the step's settings still. */
  resume() {
    const kept = remembered();
    if (this.step !== null || kept === null || this.session.controllable().length === 0) return;
    if (kept.session !== this.session.scene.session || !STEPS[kept.step]) {
      remember(null);
      return;
    }
    this.before = kept.before;
    this.panel.hidden = false;
    this.step = kept.step;
    this.show();
    this.onMove();
  }

  go(step) {
    if (step < 0 || step >= STEPS.length) return;
    this.step = step;
    this.half = 0;
    remember({ session: this.session.scene.session, step, before: this.before });
    this.show();
    this.set();
    this.onMove();
  }

  show() {
    const step = STEPS[this.step];
    const write = (name, text) => { this.panel.querySelector(`.${name}`).textContent = text; };
    write("count", `Step ${this.step + 1} of ${STEPS.length}`);
    write("title", step.title);
    write("text", `${step.text(this.session, this.half)} ${this.techniqueInWords()}`);
    write("look", typeof step.look === "function" ? step.look(this.half, this.session) : step.look);
    const focused = document.activeElement;
    this.panel.querySelector(".back").disabled = this.step === 0;
    this.panel.querySelector(".next").disabled = this.step === STEPS.length - 1;
    // A button that is switched off has the focus no more, and Esc would end nothing.
    if (focused?.disabled && this.panel.contains(focused)) this.panel.focus();
    this.panel.querySelector(".again").hidden = !step.act;
    write("again", step.sign ?? "");
    const half = this.panel.querySelector(".half");
    half.hidden = !step.halves;
    if (step.halves) half.textContent = step.halves[1 - this.half];
  }

  /** What this step has set for all peers. */
  techniqueInWords() {
    const { technique } = STEPS[this.step];
    const name = without(this.session) ? WITHOUT : typeof technique === "function" ? technique(this.half) : technique;
    return `All peers use the technique “${name}” in this step.`;
  }

  set() {
    return this.give(STEPS[this.step].set);
  }

  async give(orders) {
    const answers = await Promise.all(orders(this.orders, this.session, this.half));
    this.complain(answers.filter((a) => !a.ok));
  }

  complain(refused) {
    this.panel.querySelector(".status").textContent = refused.length > 0 ? `✗ ${together(refused[0].text)}` : "";
  }

  async end() {
    if (this.step === null) return;
    this.close();
    const refused = await this.orders.restore(this.before);
    this.restored?.(refused);
  }

  /** Another session: what was remembered is of no use there. */
  forget() {
    if (this.step === null) return;
    this.close();
  }

  close() {
    const focused = this.panel.contains(document.activeElement);
    this.step = null;
    remember(null);
    this.panel.hidden = true;
    this.onMove();
    if (focused) this.left?.();
  }
}

// Of this tab. Storage may be forbidden; then who loads the page again has to restore by hand.
function remembered() {
  try {
    return JSON.parse(sessionStorage.getItem(KEPT));
  } catch {
    return null;
  }
}

function remember(tour) {
  try {
    if (tour === null) sessionStorage.removeItem(KEPT);
    else sessionStorage.setItem(KEPT, JSON.stringify(tour));
  } catch {
    // As long as the page, then.
  }
}
