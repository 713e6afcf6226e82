// Driving one avatar from this page: keys, pointer or gamepad become `drive` messages. A direction is told when it changes
// and again all the while, since the program lets go of an avatar of which it hears nothing.

const AGAIN = 300; // ms
const SOONEST = 33; // ms between two targets of the pointer
const LEASE = 1000; // ms without a word from here after which the program lets go
const DEAD = 0.2; // of a gamepad's stick
const KEYS = {
  KeyW: [0, 1], ArrowUp: [0, 1],
  KeyS: [0, -1], ArrowDown: [0, -1],
  KeyA: [-1, 0], ArrowLeft: [-1, 0],
  KeyD: [1, 0], ArrowRight: [1, 0],
};

export class Driver {
  constructor(connection, session) {
    this.connection = connection;
    this.session = session;
    this.slot = null;
    this.held = new Set();
    this.target = null;
    this.last = "";
    this.sentAt = 0;
    this.changed = () => {}; // called with what to say, or null
    addEventListener("keydown", (e) => this.key(e, true));
    addEventListener("keyup", (e) => this.key(e, false));
    addEventListener("blur", () => this.letGoOfKeys());
    document.addEventListener("visibilitychange", () => (document.hidden ? this.letGoOfKeys() : this.shownAgain()));
  }

  async start(slot) {
    if (this.slot === slot) return;
    if (this.slot !== null) this.release();
    this.slot = slot;
    this.letGoOfKeys();
    this.last = "[0,0]";
    this.sentAt = performance.now();
    this.changed(null);
    const answer = await this.connection.ask({ type: "drive", peer: slot, direction: [0, 0] });
    if (!answer.ok && this.slot === slot) {
      this.slot = null;
      this.changed(`Peer ${slot} cannot be driven: ${answer.text}`);
    }
  }

  release() {
    if (this.slot === null) return;
    this.connection.send({ type: "drive", peer: this.slot, release: true });
    this.forget(null);
  }

  /** Drives nobody any more, without a word to the program: it knows, or is not there. */
  forget(why) {
    this.slot = null;
    this.letGoOfKeys();
    this.changed(why);
  }

  /** While the page is hidden no frame is drawn, so nothing is sent. */
  shownAgain() {
    if (this.slot === null || performance.now() - this.sentAt < LEASE) return;
    this.forget(`Avatar ${this.slot} was let go, as this page was hidden.`);
  }

  taken(slot) {
    if (slot === this.slot) this.forget(`Somebody else drives peer ${slot} now.`);
  }

  /** The pointer is held on the driven view: the avatar comes there; null when it is let go. */
  follow(point) {
    this.target = point;
  }

  letGoOfKeys() {
    this.held.clear();
    this.target = null;
  }

  key(event, down) {
    if (down && event.code === "Escape") {
      this.release();
      return;
    }
    if (this.slot === null) return;
    // It would scroll the picture away.
    if (event.code === "Space" && event.target === document.body) event.preventDefault();
    if (!(event.code in KEYS)) return;
    if (event.ctrlKey || event.altKey || event.metaKey || (down && isForText(event.target))) return;
    if (down) this.held.add(event.code);
    else this.held.delete(event.code);
    event.preventDefault();
    this.tick();
  }

  direction() {
    let [x, y] = [0, 0];
    for (const code of this.held) {
      x += KEYS[code][0];
      y += KEYS[code][1];
    }
    const length = Math.hypot(x, y);
    if (length > 0) return [round(x / length), round(y / length)];
    return stick() ?? [0, 0];
  }

  /** Once a frame of the screen, and at once when a key changes. */
  tick() {
    if (this.slot === null) return;
    const now = performance.now();
    const pointed = this.target !== null && this.held.size === 0;
    const what = pointed ? { target: [round(this.target.x), round(this.target.y)] } : { direction: this.direction() };
    const text = JSON.stringify(what);
    const since = now - this.sentAt;
    if (text === this.last ? since < AGAIN : pointed && since < SOONEST) return;
    this.last = text;
    this.sentAt = now;
    this.connection.send({ type: "drive", peer: this.slot, ...what });
  }
}

function round(v) {
  return Math.round(v * 1000) / 1000;
}

function isForText(element) {
  return element instanceof HTMLElement && element.closest("input, select, textarea, [contenteditable]") !== null;
}

/** The direction of the first gamepad's left stick or cross, or null. */
function stick() {
  for (const pad of navigator.getGamepads?.() ?? []) {
    if (!pad || !pad.connected) continue;
    const pressed = (i) => (pad.buttons[i]?.pressed ? 1 : 0);
    const x = (pad.axes[0] ?? 0) + pressed(15) - pressed(14);
    const y = -(pad.axes[1] ?? 0) + pressed(12) - pressed(13);
    const length = Math.hypot(x, y);
    if (length < DEAD) continue;
    return [round(x / Math.max(1, length)), round(y / Math.max(1, length))];
  }
  return null;
}
