// The WebSocket to padr-monitor: reconnects by itself, hands messages on by type, matches answers to what was asked.

const FIRST_WAIT = 500; // ms until the first new attempt
const LONGEST_WAIT = 5000;
const PER_SECOND = 100; // messages sent at most; the program allows 200
const GOING_AWAY = 1001; // RFC 6455, section 7.4.1
const PATIENCE = 4000; // ms until an answer counts as missing

export class Connection {
  /** `listeners`: functions by message type, and `binary`, `open`, `lost`; `sample`: what to ask for, null for the session. */
  constructor(listeners, sample) {
    this.sample = sample;
    this.listeners = listeners;
    this.wait = FIRST_WAIT;
    this.asked = new Map();
    this.lastId = 0;
    this.queue = [];
    this.sent = [];
    // A browser may keep a page that was left, and its WebSocket with it: it would still count as one that looks on.
    addEventListener("pagehide", () => this.socket.close());
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const what = this.sample === null ? "" : `?sample=${encodeURIComponent(this.sample)}`;
    this.socket = new WebSocket(`${scheme}://${location.host}/ws${what}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.wait = FIRST_WAIT;
      this.tell("open");
    };
    this.socket.onmessage = (event) => this.receive(event.data);
    this.socket.onclose = (event) => this.lost(event.code === GOING_AWAY);
  }

  /** `ended`: the program has said goodbye. */
  lost(ended) {
    for (const { done } of this.asked.values()) done({ ok: false, text: "the connection was lost" });
    this.asked.clear();
    this.queue = [];
    this.tell("lost", ended);
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(this.wait * 1.6, LONGEST_WAIT);
  }

  tell(type, message) {
    this.listeners[type]?.(message);
  }

  receive(data) {
    if (data instanceof ArrayBuffer) {
      this.tell("binary", data);
      return;
    }
    const message = JSON.parse(data);
    if (message.type === "answer") {
      this.answered(message);
      return;
    }
    this.tell(message.type, message);
  }

  answered(message) {
    const asked = this.asked.get(message.id);
    this.asked.delete(message.id);
    if (asked) asked.done(message);
    else if (!message.ok) this.tell("refused", message);
  }

  isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  /** Sends a message that wants no answer. */
  send(message) {
    if (!this.isOpen()) return;
    this.queue.push(message);
    this.pump();
  }

  /** Sends a message; a promise of its answer, {ok, text}, which never fails. */
  ask(message) {
    return new Promise((done) => {
      if (!this.isOpen()) {
        done({ ok: false, text: "not connected" });
        return;
      }
      const id = ++this.lastId;
      this.asked.set(id, { done });
      setTimeout(() => {
        if (this.asked.delete(id)) done({ ok: false, text: "no answer" });
      }, PATIENCE);
      this.send({ ...message, id });
    });
  }

  /** Sends what waits, as far as the rate allows. */
  pump() {
    const now = performance.now();
    while (this.sent.length > 0 && this.sent[0] < now - 1000) this.sent.shift();
    while (this.queue.length > 0 && this.sent.length < PER_SECOND && this.isOpen()) {
      this.sent.push(now);
      this.socket.send(JSON.stringify(this.queue.shift()));
    }
    if (this.queue.length > 0 && !this.timer) {
      this.timer = setTimeout(() => {
        this.timer = null;
        this.pump();
      }, 100);
    }
  }
}
