// What happened: kept for the marks in the plots, and listed in words, newest first.

import { clock } from "./plots.js";

const KEPT = 5000; // of frequent kinds, and of the others
const LISTED = 60;
// As is_frequent() of the program has them.
const FREQUENT = ["contact_begin", "contact_end", "authority", "release", "drive", "drive_end"];

// In words, where the program gives none. `thing` is "body 5" or "avatar 1"; `other` another peer.
const WORDS = {
  contact_begin: (thing) => `touches ${thing}`,
  contact_end: (thing) => `lets go of ${thing}`,
  authority: (thing, other) => `${thing} is peer ${other}'s now`,
  release: (thing) => `${thing} is nobody's now`,
  joined: (_, other) => `peer ${other} came in`,
  left: (_, other) => `peer ${other} has left`,
  removed: (_, other) => `peer ${other} was declared gone`,
  life: () => "begins to play",
  end: () => "has ended",
  mismatch: () => "confirmed worlds differ",
  drive: () => "is driven",
  drive_end: () => "goes its own way again",
  cut: (_, other) => (other === null ? "cut off from all" : `cut off from peer ${other}`),
  cut_end: (_, other) => (other === null ? "hears all again" : `hears peer ${other} again`),
  pause: () => "stands still",
  pause_end: () => "goes on",
  push: (thing) => `pushes ${thing}`,
};

/** What happened, in words; `bodies` is how many the scene has, as avatars are numbered after them. */
export function inWords(event, bodies) {
  const { entity } = event;
  const thing = entity === null || entity === undefined ? "" : entity < bodies ? `body ${entity}` : `avatar ${entity - bodies}`;
  const what = WORDS[event.kind]?.(thing, event.other ?? null);
  if (what && event.text && event.kind !== "life") return `${what} (${event.text})`;
  return what ?? (event.text ? `${event.kind.replaceAll("_", " ")}: ${event.text}` : event.kind.replaceAll("_", " "));
}

function isFrequent(event) {
  return FREQUENT.includes(event.kind);
}

/** The newest KEPT of frequent kinds and of the others: what happens all the time shall not push out the rest. */
function newest(events) {
  const room = { true: KEPT, false: KEPT };
  return [...events].reverse().filter((e) => room[isFrequent(e)]-- > 0).reverse();
}

export class Events {
  constructor(list, everything, session) {
    this.session = session;
    this.element = list;
    this.everything = everything; // check box: contacts too
    this.list = [];
    this.stale = true;
    everything.addEventListener("change", () => this.show(true));
  }

  /** An event in words, with who tells it. */
  words(event) {
    const who = event.peer === null || event.peer === undefined || event.peer === 255 ? "" : `peer ${event.peer}: `;
    return who + inWords(event, this.session.scene?.bodies.length ?? 0);
  }

  begin() {
    this.list = [];
    this.stale = true;
  }

  add(events) {
    this.list.push(...events);
    this.list.sort((a, b) => a.time - b.time); // what one peer tells may come after what another tells of later
    if (this.list.length > 2 * KEPT) this.list = newest(this.list);
    this.stale = true;
  }

  show(force = false) {
    if (!this.stale && !force) return;
    this.stale = false;
    const wanted = this.everything.checked ? this.list : this.list.filter((e) => !isFrequent(e));
    const lines = wanted.slice(-LISTED).reverse().map((e) => `${clock(e.time)} ${this.words(e)}`);
    this.element.replaceChildren(...(lines.length > 0 ? lines : ["nothing yet"]).map((line) => {
      const item = document.createElement("li");
      item.textContent = line;
      return item;
    }));
  }
}
