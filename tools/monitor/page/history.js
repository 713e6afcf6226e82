// Points of the plots over time, with bounded memory: four a second for the newest minutes, one every two seconds before
// them, an hour at most.

const FINE = 300; // s at full detail
const COARSE = 2; // s between older points
const LONGEST = 3600; // s
const TIDY_EVERY = 400; // points between two tidyings

export class History {
  constructor() {
    this.clear();
  }

  clear() {
    this.points = [];
    this.slots = [];
    this.untidy = 0;
    this.version = 0; // changes when rows made before no longer fit
  }

  /** Takes a `series` message; one that is older than the newest (after a new start) begins anew. */
  add(series) {
    if (this.points.length > 0 && series.time < this.points.at(-1).time - 2) this.clear();
    if (this.points.length > 0 && series.time <= this.points.at(-1).time) return;
    this.points.push(compact(series));
    for (const p of series.peers) {
      if (this.slots.includes(p.slot)) continue;
      this.slots = [...this.slots, p.slot].sort((a, b) => a - b);
      ++this.version;
    }
    if (++this.untidy >= TIDY_EVERY) this.tidy();
  }

  tidy() {
    this.untidy = 0;
    const newest = this.points.at(-1).time;
    let last = -Infinity;
    this.points = this.points.filter((p) => {
      if (p.time < newest - LONGEST) return false;
      if (p.time > newest - FINE) return true;
      if (p.time - last < COARSE) return false;
      last = p.time;
      return true;
    });
    ++this.version;
  }
}

function compact(series) {
  return {
    time: series.time,
    peers: new Map(series.peers.map((p) => [p.slot, p])),
  };
}
