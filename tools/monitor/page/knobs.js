// The panel of knobs: what is set here goes to all peers or to the one chosen, and what holds is read back from them.

import { metres } from "./views.js";

/** Networks that people know; the words are those of tc-netem. */
export const NETWORKS = [
  ["perfect", ""],
  ["one house: 2 ms", "delay 2ms"],
  ["one country: 20 ms", "delay 20ms 3ms"],
  ["across an ocean: 80 ms", "delay 80ms 10ms loss 0.5%"],
  ["mobile: 100 ms ± 50 ms, 10 % lost", "delay 100ms 50ms loss 10%"],
  ["bad: 250 ms ± 100 ms, 20 % lost", "delay 250ms 100ms loss 20%"],
];

const WITHOUT = "avatar-only"; // the technique without authority
const DIFFER = "differ"; // the entry of a list where peers differ
const SETTLED = 1500; // ms after a change until what peers say moves the control again

export class Knobs {
  constructor(panel, session, orders) {
    this.panel = panel;
    this.session = session;
    this.orders = orders;
    this.touched = new Map();
    this.differing = new Set(); // sliders of knobs that differ from peer to peer
    this.inForce = new Map(); // m, by slider that nobody has moved: it may be beyond the slider's ends
    const $ = (name) => panel.querySelector(`[name="${name}"]`);
    this.inputs = Object.fromEntries(
      ["peer", "technique", "high", "low", "body", "replay", "model", "predictor", "convergence", "other", "value",
        "from", "to", "network", "spec", "cutPeer", "cutWith", "cutWays"].map((n) => [n, $(n)]));
    this.network = panel.querySelector(".network .status");
    this.technique = panel.querySelector(".technique .status");
    this.actions = panel.querySelector(".actions .status");
    for (const [name, spec] of NETWORKS) this.inputs.network.append(new Option(name, spec));
    this.inputs.network.append(new Option("as written below", "?"));
    this.listen();
  }

  listen() {
    const { inputs } = this;
    const knob = (input, name, value) => input.addEventListener("change", () => this.turn(name, value(input)));
    knob(inputs.technique, "technique", (i) => i.value);
    // A list tells of no choice that changes nothing.
    this.panel.querySelector("button.afresh").addEventListener("click", () => {
      this.touched.clear();
      if (inputs.technique.value !== DIFFER) this.turn("technique", inputs.technique.value);
    });
    knob(inputs.replay, "replay", (i) => (i.checked ? "on" : "off"));
    for (const name of ["model", "predictor", "convergence"]) knob(inputs[name], name, (i) => i.value);
    knob(inputs.body, "body-threshold", (i) => (this.metres(i) > 0 ? String(this.metres(i)) : "off"));
    for (const side of ["high", "low"]) {
      inputs[side].addEventListener("input", () => this.slide(side));
      inputs[side].addEventListener("change", () => this.turn("threshold", this.thresholds()));
    }
    inputs.body.addEventListener("input", () => this.slide("body"));
    for (const input of Object.values(inputs)) {
      for (const kind of ["input", "change"]) input.addEventListener(kind, () => this.touched.set(input, performance.now()));
    }
    inputs.peer.addEventListener("change", () => {
      this.touched.clear();
      this.update();
    });
    inputs.other.addEventListener("change", () => this.explain());
    inputs.network.addEventListener("change", () => {
      if (inputs.network.value === "?") return;
      inputs.spec.value = inputs.network.value;
      this.shape();
    });
    for (const name of ["from", "to"]) inputs[name].addEventListener("change", () => this.touched.delete(inputs.spec));
    this.panel.querySelector("form.link").addEventListener("submit", (e) => {
      e.preventDefault();
      this.shape();
    });
    this.panel.querySelector("form.any").addEventListener("submit", (e) => {
      e.preventDefault();
      this.turn(inputs.other.value, inputs.value.value.trim());
    });
    this.button("pause", () => this.orders.pause(this.peer(), true), "paused, for 600 s at most; whom is chosen under “Technique”");
    this.button("resume", () => this.orders.pause(this.peer(), false), "going on");
    this.button("cut", () => this.cut(5), "cut off for 5 s");
    this.button("throw", () => this.throwBody(), "thrown");
    this.button("topple", () => this.orders.push(0, [2.5, 0]), "pushed the first one");
  }

  cut(seconds) {
    const { cutPeer, cutWith, cutWays } = this.inputs;
    const partner = cutWith.value === "all" ? "all" : Number(cutWith.value);
    return this.orders.cut(Number(cutPeer.value), partner, seconds, cutWays.value);
  }

  button(name, action, done) {
    this.panel.querySelector(`button.${name}`).addEventListener("click", async () => say(this.actions, await action(), done));
  }

  /** Throws the ball; where there is no ball, some light body. */
  throwBody() {
    const { scene } = this.session;
    const lightest = Math.min(...scene.bodies.map((b) => b.mass));
    const light = scene.bodies.map((b, id) => ({ id, mass: b.mass })).filter((b) => b.mass <= lightest * 2);
    const { id } = light[Math.floor(Math.random() * light.length)];
    const turn = Math.random() * 2 * Math.PI;
    const fast = scene.gravity[1] < 0 ? 5 : 12;
    const up = scene.gravity[1] < 0 ? 4 : fast * Math.sin(turn);
    return this.orders.push(id, [Math.round(fast * Math.cos(turn) * 100) / 100, Math.round(up * 100) / 100]);
  }

  peer() {
    return number(this.inputs.peer.value);
  }

  async turn(name, value) {
    const peer = this.peer();
    const answer = await this.orders.knob(peer, name, value);
    say(this.technique, answer, `${name} ${value}: ${peer === "all" ? "all peers" : `peer ${peer}`}`);
    if (!answer.ok) {
      this.touched.clear();
      this.update();
    }
  }

  async shape() {
    const { from, to, spec } = this.inputs;
    const answer = await this.orders.netem(number(from.value), number(to.value), spec.value.trim());
    say(this.network, answer, spec.value.trim() === "" ? "no impairment" : spec.value.trim());
    // What was refused stays to be put right; the message names a word of it.
    if (answer.ok) this.touched.delete(spec);
    else this.touched.set(spec, Infinity);
  }

  thresholds() {
    const [high, low] = [this.inputs.high, this.inputs.low].map((input) => this.metres(input));
    return high === low ? String(high) : `${high}:${low}`;
  }

  /** What a slider stands for. */
  metres(slider) {
    return this.inForce.get(slider) ?? Number(slider.value);
  }

  /** Keeps the low threshold below the high one, and says what the sliders stand at. */
  slide(side) {
    const { high, low, body } = this.inputs;
    if (side) this.inForce.delete(this.inputs[side]);
    const other = { high: low, low: high }[side];
    if (other && this.metres(low) > this.metres(high)) {
      other.value = this.inputs[side].value;
      this.inForce.delete(other);
    }
    for (const input of [high, low, body]) {
      const off = input === body && this.metres(input) === 0;
      if (side) this.differing.delete(input);
      const text = this.differing.has(input) ? "differ" : off ? "off" : distance(this.metres(input));
      input.nextElementSibling.textContent = text;
      input.setAttribute("aria-valuetext", text);
    }
  }

  explain() {
    const knob = this.session.hello?.knobs.find((k) => k.name === this.inputs.other.value);
    this.inputs.value.placeholder = knob?.type ?? "";
    this.inputs.value.title = knob?.help ?? "";
  }

  /** Lists that follow from what the program and the peers can do. */
  begin() {
    const { hello } = this.session;
    if (!hello) return;
    options(this.inputs.technique, hello.techniques);
    options(this.inputs.other, hello.knobs.map((k) => k.name).filter((n) => n !== "technique"));
    this.inputs.spec.title = hello.netem_help ?? "";
    this.explain();
  }

  update() {
    const { session, inputs, panel } = this;
    const peers = session.controllable();
    const slots = peers.map((p) => p.slot);
    panel.classList.toggle("off", peers.length === 0);
    for (const set of panel.querySelectorAll("fieldset")) set.disabled = peers.length === 0;
    panel.querySelector(".why").textContent = whyNot(session, peers);
    for (const name of ["peer", "from", "to"]) options(inputs[name], ["all", ...(name === "to" ? session.present().map((p) => p.slot) : slots)], (s) => (s === "all" ? "all peers" : `peer ${s}`));
    const pause = panel.querySelector("button.pause");
    const whom = this.peer() === "all" ? "Pause all" : `Pause peer ${this.peer()}`;
    if (pause.textContent !== whom) pause.textContent = whom;
    options(inputs.cutPeer, slots, (s) => `peer ${s}`);
    options(inputs.cutWith, ["all", ...session.present().map((p) => p.slot)], (s) => (s === "all" ? "all" : `peer ${s}`));
    if (session.scene) {
      panel.querySelector("button.topple").hidden = session.scene.name !== "dominoes";
      panel.querySelector("button.throw").hidden = session.scene.bodies.length === 0;
      panel.querySelector("button.throw").textContent = session.scene.bodies.length === 1 || session.scene.name === "ball" ? "Throw the ball" : "Throw a body";
    }
    // Who may only look sees what holds, too.
    this.readBack(peers.length > 0 ? peers : session.present());
  }

  /** Moves the controls to what holds, where nobody is at them. */
  readBack(peers) {
    const chosen = this.peer() === "all" ? peers : peers.filter((p) => p.slot === this.peer());
    const common = (name) => same(chosen.map((p) => p.knobs?.[name]));
    const { inputs } = this;
    const set = (input, value, several = chosen.length > 1) => {
      if (this.busy(input)) return;
      // A list that stood at its first entry would show what nobody has.
      if (input.tagName === "SELECT") sayThatTheyDiffer(input, value === undefined && several);
      if (value !== undefined && input.value !== value) input.value = value;
    };
    const differ = (value, ...sliders) => {
      for (const input of sliders)
        if (value === undefined && chosen.length > 1 && !this.busy(input)) this.differing.add(input);
        else this.differing.delete(input);
      if (value === undefined) for (const input of sliders) this.inForce.delete(input);
    };
    const slide = (input, value) => {
      if (!this.busy(input)) this.inForce.set(input, Number(value));
      set(input, value);
    };
    set(inputs.technique, same(chosen.map((p) => p.technique)));
    // All have to agree on authority when the session begins: it cannot change.
    const without = chosen.some((p) => p.technique === WITHOUT);
    for (const option of inputs.technique.options)
      if (option.value !== DIFFER) option.disabled = chosen.length > 0 && (option.value === WITHOUT) !== without;
    for (const name of ["model", "predictor", "convergence"]) set(inputs[name], common(name));
    const replay = common("replay");
    if (replay !== undefined && !this.busy(inputs.replay)) inputs.replay.checked = replay === "on";
    inputs.replay.indeterminate = replay === undefined && chosen.length > 1;
    const thresholds = common("threshold")?.split(":");
    differ(thresholds, inputs.high, inputs.low);
    if (thresholds) {
      slide(inputs.high, thresholds[0]);
      slide(inputs.low, thresholds[1] ?? thresholds[0]);
    }
    const body = common("body-threshold");
    differ(body, inputs.body);
    if (body !== undefined) slide(inputs.body, body === "off" ? "0" : body);
    this.slide();
    const [from, to] = [number(inputs.from.value), number(inputs.to.value)];
    const specs = peers.filter((p) => from === "all" || p.slot === from).flatMap((p) => p.links.filter((l) => to === "all" || l.to === to).map((l) => l.netem ?? ""));
    const spec = same(specs);
    if (!this.busy(inputs.spec) && !this.busy(inputs.network)) {
      inputs.spec.placeholder = spec === undefined && specs.length > 0 ? "(differs from link to link)" : "none";
      set(inputs.spec, spec ?? "");
      const known = NETWORKS.some(([, s]) => s === spec);
      set(inputs.network, known || (spec === undefined && specs.length > 1) ? spec : "?", specs.length > 1);
    }
  }

  busy(input) {
    return document.activeElement === input && input.type !== "checkbox" && input.tagName !== "SELECT"
      || performance.now() - (this.touched.get(input) ?? -Infinity) < SETTLED;
  }
}

function whyNot(session, peers) {
  if (peers.length > 0) return "";
  if (!session.hello || session.replayed()) return "";
  if (session.offline) return "Not connected to padr-monitor.";
  if (!session.hello.control) return session.hello.needs_token ? "To turn knobs from here, add #token= and the monitor's token to the page's address." : "This page may only look.";
  return session.present().length === 0 ? "" : "No peer lets itself be controlled: start them with --control.";
}

/** Says how it went; that it went well, without a warning, only for a while, as others may turn the same knob. */
export function say(output, answer, done) {
  const warning = answer.text ? `. Warning: ${answer.text}` : "";
  output.textContent = answer.ok ? `✓ ${done}${warning}` : `✗ ${together(answer.text)}`;
  output.classList.toggle("error", !answer.ok);
  const said = output.textContent;
  if (answer.ok && !warning) setTimeout(() => { if (output.textContent === said) output.textContent = ""; }, 8000);
}

/** "peer 1: no; peer 2: no" as "all: no". */
export function together(text) {
  const parts = text.split("; ").map((part) => part.replace(/^peer \d+: /, ""));
  return parts.length > 1 && parts.every((part) => part === parts[0]) ? `all: ${parts[0]}` : text;
}

function number(text) {
  return text === "all" ? "all" : Number(text);
}

/** The value that all have, or undefined. */
function same(values) {
  return values.length > 0 && values.every((v) => v === values[0]) ? values[0] ?? undefined : undefined;
}

/** Puts the entry that says so into a list, chosen, or takes it away; nobody can choose it. */
function sayThatTheyDiffer(select, differ) {
  const entry = [...select.options].find((o) => o.value === DIFFER);
  if (!differ) {
    entry?.remove();
    return;
  }
  if (!entry) {
    const made = new Option(DIFFER, DIFFER);
    made.disabled = made.hidden = true;
    select.prepend(made);
  }
  select.value = DIFFER;
}

/** Makes a list have these choices, and keeps the one that was chosen. */
function options(select, values, text = String) {
  const wanted = values.map(String);
  if ([...select.options].map((o) => o.value).join() === wanted.join()) return;
  const { value } = select;
  select.replaceChildren(...values.map((v) => new Option(text(v), v)));
  if (wanted.includes(value)) select.value = value;
}

/** A threshold, which may be of millimetres. */
function distance(m) {
  if (m > 0 && m < 0.01) return `${Math.round(m * 1000)} mm`;
  return m < 0.0995 ? `${Math.round(m * 1000) / 10} cm` : metres(m);
}
