// Orders to peers, for the knobs and for the tour: technique and settings, impairment of links, cuts, pauses, pushes; and
// how all settings were, so that they can be brought back.

export class Orders {
  constructor(connection, session) {
    this.connection = connection;
    this.session = session;
  }

  knob(peer, name, value) {
    return this.connection.ask({ type: "knob", peer, name, value: String(value) });
  }

  netem(peer, to, spec) {
    return this.connection.ask({ type: "netem", peer, to, spec });
  }

  cut(peer, partner, seconds, ways = "both") {
    return this.connection.ask({ type: "cut", peer, with: partner, seconds, ways });
  }

  pause(peer, on) {
    return this.connection.ask({ type: "pause", peer, on });
  }

  push(body, velocity) {
    return this.connection.ask({ type: "push", peer: "any", body, velocity });
  }

  /** Every controllable peer's technique, knobs and links as they are. */
  remember() {
    return this.session.controllable().map((p) => ({
      slot: p.slot,
      technique: p.technique,
      knobs: { ...p.knobs },
      links: p.links.map((l) => ({ to: l.to, netem: l.netem ?? "" })),
    }));
  }

  /** Brings back what was remembered, on those peers that are still there; the answers that were refusals. */
  async restore(remembered) {
    const wanted = [];
    for (const was of remembered) {
      const now = this.session.controllable().find((p) => p.slot === was.slot);
      if (!now) continue;
      wanted.push(this.cut(was.slot, "all", 0), this.pause(was.slot, false));
      wanted.push(this.knob(was.slot, "technique", was.technique));
      for (const [name, value] of Object.entries(was.knobs)) {
        if (value !== null && name !== "technique") wanted.push(this.knob(was.slot, name, value));
      }
      const specs = new Set(was.links.map((l) => l.netem));
      if (specs.size === 1) wanted.push(this.netem(was.slot, "all", [...specs][0]));
      else for (const l of was.links) wanted.push(this.netem(was.slot, l.to, l.netem));
    }
    return (await Promise.all(wanted)).filter((a) => !a.ok);
  }
}
