// What the page knows of the session it shows: the newest message of each kind, brought into a handy form.

import { AWAKE } from "./draw.js";
import { Samples, SHOWN } from "./samples.js";

const STILL = 0.002; // m: places are told to the millimetre

export class Session {
  constructor() {
    this.hello = null;
    this.offline = null; // why there is no connection, in words
    this.samples = new Samples();
    this.timeline = null;
    this.token = null;
    this.begin(null);
  }

  /** A scene begins anew: nothing of before holds. */
  begin(scene) {
    this.scene = scene && filledIn(scene);
    this.peers = { peers: [], agreement: { state: "unknown" } };
    this.played = false; // somebody was there
    this.begun = false; // something has moved, or come to rest
    this.points = new Map(); // newest series point by slot
    this.samples.begin(scene ? scene.bodies.length + scene.slots : 0);
  }

  replayed() {
    return this.hello !== null && this.hello.mode !== "live";
  }

  mayControl() {
    return this.hello !== null && this.hello.control;
  }

  peer(slot) {
    return this.peers.peers.find((p) => p.slot === slot);
  }

  /** Peers that are there or silent; those gone stay in the table only. */
  present() {
    return this.peers.peers.filter((p) => p.state !== "gone");
  }

  /** Those of them that have an avatar: all but spectators. */
  players() {
    return this.present().filter((p) => p.input !== "none");
  }

  controllable() {
    return this.mayControl() && this.offline === null ? this.present().filter((p) => p.controllable) : [];
  }

  /** Those of them whose avatar can be driven now. */
  drivable() {
    return this.waits() ? [] : this.controllable().filter((p) => p.input !== "none");
  }

  /** Peers are there, and wait for others (--wait-peers). They do not tell so. But no world is stepped then: every body is as the
   *  scene has it, and awake, while in play whatever nobody touches is asleep within half a second. */
  waits() {
    if (this.begun || this.replayed() || !this.scene || this.scene.bodies.length === 0) return false;
    const views = this.present().map((p) => this.samples.sample(p.slot, SHOWN)).filter(Boolean);
    if (views.length === 0) return false;
    const untouched = ({ world }) => this.scene.bodies.every((b, id) => (world.flags[id] & AWAKE) && Math.hypot(world.x[id] - b.x, world.y[id] - b.y) < STILL);
    this.begun = !views.every(untouched);
    return !this.begun;
  }

  /** Of live sessions: peers were there, and all have gone. */
  over() {
    return !this.replayed() && this.played && this.present().length === 0;
  }

  takePeers(message) {
    const unknown = { state: "unknown", tick: null, hash: null, lag_ms: null };
    const peers = message.peers.map((p) => ({ ...p, confirmed: p.confirmed ?? unknown, links: p.links ?? [] }));
    this.peers = { ...message, peers, agreement: message.agreement ?? { state: "unknown" } };
    // Who has been gone for a minute is not told of any more.
    this.played ||= peers.length > 0 || message.tick > 0;
  }

  /** Apart from the others a peer confirms a world of its own: to compare with that one says nothing. */
  isApart(peer) {
    return peer.links.some((l) => l.cut) || peer.confirmed.state === "differs" || peer.confirmed.state === "apart";
  }

  /** How far a peer's view is off, in metres; null if it is not known. */
  error(peer) {
    return this.isApart(peer) ? null : this.points.get(peer.slot)?.combined_m ?? null;
  }

  /** Of which second that is, where a recording stands at another: its last ticks were never confirmed. Else null. */
  errorAt(peer) {
    const { timeline } = this;
    const tick = this.points.get(peer.slot)?.at_tick ?? null;
    if (!this.replayed() || !timeline || timeline.playing || tick === null) return null;
    return Math.abs(timeline.tick - tick) > timeline.sample ? tick / 60 : null;
  }

  takePoint(point) {
    for (const p of point.peers) this.points.set(p.slot, p);
  }

  /** Ticks a second go by on the page: 0 while a recording stands. */
  speed() {
    if (!this.replayed()) return 1;
    return this.timeline && this.timeline.playing ? this.timeline.speed : 0;
  }

  /** A recording stands still: nobody plays it any more. */
  stand() {
    if (this.timeline) this.timeline = { ...this.timeline, playing: false };
  }

  takeTimeline(timeline) {
    const before = this.timeline;
    this.timeline = timeline;
    if (before && timeline.tick < before.tick) this.samples.clear();
  }
}

function filledIn(scene) {
  const shape = (s) => ({
    radius: s.shape === "circle" ? s.radius : 0,
    half: s.half ?? [0, 0],
    mass: s.mass ?? 0,
    angle: s.angle ?? 0,
    x: s.position[0],
    y: s.position[1],
  });
  return {
    ...scene,
    bodies: scene.bodies.map(shape),
    statics: scene.statics.map(shape),
    avatar: { half: [0, 0], ...scene.avatar },
  };
}
