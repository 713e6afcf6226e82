// The table of peers and the one of links. Cells are kept and only their text changes, so that nothing flickers and what is
// selected stays selected.

import { hue, ink } from "./palette.js";

const VERDICTS = { identical: "✓ identical", apart: "↮ apart", differs: "✗ differs", unknown: "… not yet known" };

const COLUMNS = [
  { head: "peer", cell: (p) => String(p.slot), paint: (td, p) => dot(td, p.slot) },
  { head: "state", cell: (p) => (p.paused ? "paused" : p.state), title: "here; silent: its program has told nothing for a second; or gone" },
  {
    head: "confirmed world",
    title: "The newest state that this peer knows to be final: a hash over every bit of it, and its tick. Each peer's newest is of another tick, so hashes differ; they are compared at equal ticks",
    cell: (p) => (p.state === "gone" ? "–" : `${VERDICTS[p.confirmed.state] ?? p.confirmed.state}${hash(p.confirmed)}`),
    paint: (td, p) => { td.dataset.verdict = p.confirmed.state; },
  },
  { head: "confirmed lag", title: "How far the confirmed world is behind the live one", cell: (p) => number(p.state === "gone" ? null : p.confirmed.lag_ms, 0, " ms") },
  { head: "off by", title: "Inconsistency: distance to where the authority has it, all entities summed; live, the mean since the last point of the plots; in a recording, of this very moment", cell: (p, point, session) => number(session.error(p), 2, " m") },
  { head: "fidelity error", recorded: true, title: "Distance of bodies to where the players' deeds alone put them, all summed; of recordings only", cell: (p, point) => number(point?.fidelity_m, 2, " m") },
  { head: "updates", title: "Entity state updates sent", cell: (p) => number(sum(p.rates?.updates_per_s), 1, " /s") },
  { head: "traffic", title: "Sent, with IP and UDP headers", cell: (p) => number(p.rates?.kbit_per_s, 1, " kbit/s") },
  { head: "thresholds", title: "Where links or the budget are too narrow, all thresholds are multiplied by this", cell: (p) => number(p.price, 1, "×") },
  { head: "replayed", title: "Steps played again because something came late, for each tick", cell: (p) => number(p.rates?.replayed_per_tick, 1, " /tick") },
  { head: "late ticks", title: "Ticks that began late on that machine", cell: (p) => number(p.late_ticks, 0) },
  {
    head: "dropped",
    title: "Datagrams of other peers that it did not take for what they said, and whom it has cut off for that",
    cell: (p) => dropWords(p.drops),
    paint: (td, p) => { td.dataset.cut = p.drops.some((d) => d.cut_off > 0) ? "yes" : "no"; },
    tip: (p) => p.drops.map(dropReasons).join("\n"),
  },
  { head: "technique", cell: (p) => p.technique ?? "–", title: (p) => p.settings },
  { head: "address", cell: (p) => p.address || "–" },
  { head: "incarnation", title: "Number with which it came into the session, the higher the later", cell: (p) => String(p.incarnation ?? "–") },
  { head: "version", title: (p) => p.version ?? "", cell: (p) => p.version?.split(" ")[0] ?? "–" },
];

/** With its tick: those of other peers are of other ticks. */
function hash({ tick, hash }) {
  return hash ? ` ${hash.slice(0, 8)} at ${tick}` : "";
}

export class Tables {
  constructor(peersTable, linksTable, verdict, details) {
    this.details = details;
    this.peers = new Grid(peersTable);
    this.links = new Grid(linksTable);
    this.verdict = verdict;
  }

  update(session) {
    const rows = session.peers.peers;
    const columns = COLUMNS.filter((c) => !c.recorded || session.replayed());
    this.peers.show(
      columns.map((c) => ({ text: c.head, title: typeof c.title === "string" ? c.title : "" })),
      rows.map((p) => ({
        state: p.state,
        cells: columns.map((c) => ({
          text: c.cell(p, session.points.get(p.slot), session),
          title: c.tip?.(p) ?? (typeof c.title === "function" ? c.title(p) : ""),
          paint: c.paint && ((td) => c.paint(td, p)),
        })),
      })),
    );
    this.updateLinks(session.present());
    this.explain(columns, rows);
    this.judge(session.peers.agreement);
  }

  /** What cells say when they are pointed at, for who has no mouse. */
  explain(columns, rows) {
    const lines = columns.filter((c) => typeof c.title === "string").map((c) => `${c.head}: ${c.title}.`);
    for (const p of rows) {
      const dropped = p.drops.map(dropReasons).map((reasons) => ` Dropped ${reasons}.`).join("");
      lines.push(`peer ${p.slot}: ${p.settings ?? "settings not told"}; version ${p.version ?? "not told"}.${dropped}`);
    }
    const told = lines.join("\n");
    if (told === this.explained) return;
    this.explained = told;
    this.details.replaceChildren(...lines.map((line) => {
      const item = document.createElement("li");
      item.textContent = line;
      return item;
    }));
  }

  updateLinks(peers) {
    const head = [{ text: "from \\ to", title: "One-way delay (median and 95th percentile of the latest datagrams), loss of the latest ones; who carries, if the link does not work; what it carries, if that is too little; and the impairment that the sender puts on it" }, ...peers.map((p) => ({ text: `peer ${p.slot}` }))];
    this.links.show(head, peers.map((from) => ({
      state: from.state,
      cells: [{ text: `peer ${from.slot}`, paint: (td) => dot(td, from.slot) }, ...peers.map((to) => linkCell(from, to))],
    })));
  }

  judge(agreement) {
    const { verdict } = this;
    verdict.dataset.verdict = agreement.state;
    const since = agreement.state === "differs" ? ` since tick ${agreement.first_difference}` : "";
    setText(verdict.lastElementChild, `${VERDICTS[agreement.state] ?? agreement.state}${since}`);
    verdict.title = `The state that peers know to be final, compared bit by bit by its hash, at equal ticks: ${agreement.compared ?? 0} so far${agreement.state === "apart" ? ". Peers that are cut off from each other go on in worlds of their own until they meet again" : ""}`;
  }
}

/** Delay and loss are what the receiver measures, the rest is what the sender does. */
function linkCell(from, to) {
  if (from.slot === to.slot) return { text: "" };
  const sends = from.links.find((l) => l.to === to.slot);
  const hears = to.links.find((l) => l.to === from.slot);
  if (!sends || !hears) return { text: "–" };
  if (sends.cut === "both" || sends.cut === "out" || hears.cut === "both" || hears.cut === "in") return { text: "✂ cut", paint: (td) => { td.dataset.cut = "yes"; } };
  const parts = [`${number(hears.delay_ms, 0, " ms")}, p95 ${number(hears.delay_p95_ms, 0, " ms")}`];
  if (hears.loss_percent > 0) parts.push(`${number(hears.loss_percent, 1, " %")} of ${hears.loss_of} lost`);
  if (sends.carried_by !== null) parts.push(`by peer ${sends.carried_by}`);
  if (sends.carries_kbit_s !== null) parts.push(`carries ${number(sends.carries_kbit_s, 1, " kbit/s")}`);
  const netem = sends.netem ? ` [${sends.netem}]` : "";
  return { text: parts.join(", "), title: linkTitle(sends, hears), paint: (td) => { td.dataset.netem = netem; delete td.dataset.cut; } };
}

function linkTitle(sends, hears) {
  const delay = `one-way delay: median ${number(hears.delay_ms, 1, " ms")}, 95th percentile ${number(hears.delay_p95_ms, 1, " ms")}, least ${number(hears.delay_least_ms, 1, " ms")}`;
  const lost = hears.judged > 0 ? `lost since the link began: ${hears.lost} of ${hears.judged}, ${number(100 * hears.lost / hears.judged, 2, " %")}` : "lost: not known yet";
  const carries = sends.carries_kbit_s === null ? "carries more than is sent" : `carries ${number(sends.carries_kbit_s, 1, " kbit/s")}, and datagrams wait ${number(sends.queue_ms, 0, " ms")} in its queue`;
  const way = sends.carried_by === null ? "reached directly" : `the link does not work: peer ${sends.carried_by} carries`;
  return `${delay}\n${lost}\n${carries}\n${way}\nnetem: ${sends.netem || "none"}`;
}

// What the network says twice or late is nobody's fault.
const BLAMELESS = ["duplicate", "foreign"];

function dropWords(drops) {
  const blamed = (d) => sum(Object.entries(d.by_reason).filter(([why]) => !BLAMELESS.includes(why)).map(([, n]) => n));
  const cut = drops.filter((d) => d.cut_off > 0).map((d) => d.from);
  return `${sum(drops.map(blamed))}${cut.length > 0 ? `, cut off: ${cut.join(" ")}` : ""}`;
}

function dropReasons(d) {
  const reasons = Object.entries(d.by_reason).map(([why, n]) => `${n} ${why.replace("_", " ")}`);
  return `of peer ${d.from}: ${reasons.join(", ") || "none"}${d.cut_off > 0 ? `; cut off, ${d.cut_off} ${d.cut_off === 1 ? "time" : "times"}` : ""}`;
}

/** A table whose cells are made once and then changed. */
class Grid {
  constructor(table) {
    this.head = table.tHead.rows[0];
    this.body = table.tBodies[0];
  }

  show(head, rows) {
    fill(this.head, head, "th");
    while (this.body.rows.length > rows.length) this.body.deleteRow(-1);
    while (this.body.rows.length < rows.length) this.body.insertRow();
    rows.forEach((row, i) => {
      this.body.rows[i].dataset.state = row.state;
      fill(this.body.rows[i], row.cells, "td");
    });
  }
}

function fill(tr, cells, kind) {
  while (tr.cells.length > cells.length) tr.deleteCell(-1);
  while (tr.cells.length < cells.length) {
    const heads = kind === "td" && tr.cells.length === 0;
    const cell = document.createElement(heads ? "th" : kind);
    if (heads) cell.scope = "row";
    else if (kind === "th") cell.scope = "col";
    tr.append(cell);
  }
  cells.forEach((c, i) => {
    setText(tr.cells[i], c.text);
    if (tr.cells[i].title !== (c.title ?? "")) tr.cells[i].title = c.title ?? "";
    c.paint?.(tr.cells[i]);
  });
}

function dot(td, slot) {
  td.className = "peer";
  td.style.setProperty("--hue", hue(slot));
  td.style.setProperty("--ink", ink(slot));
}

export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function number(value, digits, unit = "") {
  return value === null || value === undefined ? "–" : `${value.toFixed(digits).replace(/^-(?=[0.]*$)/, "")}${unit}`;
}

export function sum(values) {
  return values ? values.reduce((a, b) => a + (b ?? 0), 0) : null;
}
