// What peers told of their worlds: a short ring of frames for each view, and worlds in between, so that all views show one
// and the same moment, smoothly.
//
// The moment shown runs a little behind the newest frame: far enough that there nearly always is a later frame to
// interpolate towards, and it never runs ahead of what was told.

import { AWAKE, HELD, PRESENT } from "./draw.js";

export const SHOWN = 0;
export const LIVE = 1;
export const PREDICTED = 2;
export const CONFIRMED = 3;
export const AUTHORITY = 4;
export const VIEW_NAMES = ["shown", "live", "predicted", "confirmed", "authority"];

const HEADER = 24;
const RECORD = 16;
const KEPT = 24; // frames of a view
const TELEPORT = 3; // m between two frames: a jump, not a motion

class World {
  constructor(size) {
    this.x = new Float32Array(size);
    this.y = new Float32Array(size);
    this.angle = new Float32Array(size);
    this.owner = new Uint8Array(size);
    this.flags = new Uint8Array(size);
  }
}

class Frame {
  constructor(size) {
    this.tick = 0;
    this.flags = 0;
    this.threshold = 0;
    this.target = null;
    this.world = new World(size);
  }
}

/** The frames of one view of one peer, oldest first; their memory is used again. */
class Ring {
  constructor(size) {
    this.size = size;
    this.frames = [];
    this.spare = [];
    this.between = null;
    this.made = null; // the newest answer of at(), and of which tick
    this.arrived = 0;
  }

  clear() {
    this.spare.push(...this.frames);
    this.frames = [];
    this.made = null;
  }

  next(tick) {
    this.made = null;
    // After a jump backwards, or a new life, what was there is the future of another past.
    while (this.frames.length > 0 && this.frames.at(-1).tick >= tick) this.spare.push(this.frames.pop());
    if (this.frames.length >= KEPT) this.spare.push(this.frames.shift());
    const frame = this.spare.pop() ?? new Frame(this.size);
    this.frames.push(frame);
    frame.tick = tick;
    this.arrived = performance.now();
    return frame;
  }

  /** The world at a tick with a fraction: between the frames round it, the first before them all, the last after. */
  at(tick) {
    if (this.frames.length === 0) return null;
    if (this.made?.at !== tick) this.made = { at: tick, sample: this.make(tick) };
    return this.made.sample;
  }

  make(tick) {
    const { frames } = this;
    let i = frames.length - 1;
    while (i > 0 && frames[i].tick > tick) --i;
    const a = frames[i];
    const b = frames[i + 1];
    if (!b || tick <= a.tick) return { ...heading(a), world: a.world };
    this.between ??= new World(this.size);
    blend(this.between, a.world, b.world, (tick - a.tick) / (b.tick - a.tick));
    return { ...heading(a), world: this.between };
  }
}

function heading(frame) {
  return {
    tick: frame.tick,
    threshold: frame.threshold,
    target: frame.target,
    predicted: (frame.flags & 1) !== 0,
    paused: (frame.flags & 2) !== 0,
    driven: (frame.flags & 4) !== 0,
  };
}

function blend(out, a, b, part) {
  out.owner.set(a.owner);
  out.flags.set(a.flags);
  for (let id = 0; id < out.x.length; ++id) {
    if (!(a.flags[id] & PRESENT)) continue;
    const dx = b.x[id] - a.x[id];
    const dy = b.y[id] - a.y[id];
    const still = !(b.flags[id] & PRESENT) || dx * dx + dy * dy > TELEPORT * TELEPORT;
    const p = still ? 0 : part;
    out.x[id] = a.x[id] + dx * p;
    out.y[id] = a.y[id] + dy * p;
    const turn = b.angle[id] - a.angle[id];
    out.angle[id] = a.angle[id] + (turn - Math.round(turn / (2 * Math.PI)) * 2 * Math.PI) * p;
  }
}

export class Samples {
  constructor() {
    this.rings = new Map();
    this.size = 0;
    this.clear();
  }

  /** A new session: that many entities, nothing told yet. */
  begin(size) {
    this.size = size;
    this.rings.clear();
    this.clear();
  }

  /** Forgets what was told: after a jump in a recording. */
  clear() {
    for (const ring of this.rings.values()) ring.clear();
    this.newest = null; // tick of the newest frame of what is shown now
    this.gap = 3; // ticks between frames
    this.now = null; // the moment shown, in ticks
    this.received = 0;
  }

  ring(slot, view) {
    const key = slot * 8 + view;
    let ring = this.rings.get(key);
    if (!ring) {
      ring = new Ring(this.size);
      this.rings.set(key, ring);
    }
    return ring;
  }

  /** Takes in a binary message: one or more blocks. */
  take(buffer) {
    const data = new DataView(buffer);
    let at = 0;
    while (at + HEADER <= data.byteLength) {
      const count = data.getUint16(at + 20, true);
      const end = at + HEADER + RECORD * count;
      if (end > data.byteLength) return;
      if (data.getUint8(at) === 1) this.takeBlock(data, at, count);
      at = end;
    }
  }

  takeBlock(data, at, count) {
    const view = data.getUint8(at + 2);
    const tick = data.getInt32(at + 4, true);
    if (view > AUTHORITY) return;
    const frame = this.ring(data.getUint8(at + 1), view).next(tick);
    frame.flags = data.getUint8(at + 3);
    frame.threshold = data.getFloat32(at + 8, true);
    const x = data.getFloat32(at + 12, true);
    frame.target = Number.isNaN(x) ? null : { x, y: data.getFloat32(at + 16, true) };
    readRecords(data, at + HEADER, count, frame.world);
    ++this.received;
    // The agreed world of a capture is all there is to see.
    if (view === SHOWN || (view === CONFIRMED && data.getUint8(at + 1) === 255)) this.pace(tick);
  }

  pace(tick) {
    if (this.newest !== null && tick > this.newest && tick - this.newest < 30) {
      this.gap += (tick - this.newest - this.gap) * 0.05;
    }
    if (this.newest === null || tick > this.newest || this.newest - tick > 60) this.newest = tick;
  }

  /** Moves the moment shown on by so many seconds of a session that runs `speed` times as fast as the clock. */
  advance(seconds, speed) {
    if (this.newest === null) return;
    const wanted = this.newest - Math.max(1, this.gap * 1.2);
    const off = this.now === null ? Infinity : wanted - this.now;
    if (speed === 0 || Math.abs(off) > 45 * Math.max(1, speed)) {
      this.now = speed === 0 ? this.newest : wanted;
      return;
    }
    this.now = Math.min(this.now + seconds * 60 * speed + off * Math.min(1, seconds * 3), this.newest);
  }

  /** A peer's view at the moment shown, or null; `world` is good until the next call for the same view. */
  sample(slot, view) {
    const ring = this.rings.get(slot * 8 + view);
    return ring && this.now !== null ? ring.at(this.now) : null;
  }

  /** Milliseconds since something came of that view. */
  age(slot, view) {
    const ring = this.rings.get(slot * 8 + view);
    return ring ? performance.now() - ring.arrived : Infinity;
  }
}

function readRecords(data, from, count, world) {
  world.flags.fill(0);
  let at = from;
  for (let i = 0; i < count; ++i, at += RECORD) {
    const id = data.getUint16(at, true);
    if (id >= world.x.length) continue;
    world.owner[id] = data.getUint8(at + 2);
    const flags = data.getUint8(at + 3);
    world.flags[id] = PRESENT | (flags & 1 ? AWAKE : 0) | (flags & 2 ? HELD : 0);
    world.x[id] = data.getFloat32(at + 4, true);
    world.y[id] = data.getFloat32(at + 8, true);
    world.angle[id] = data.getFloat32(at + 12, true);
  }
}
