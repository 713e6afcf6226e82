// The plots, drawn by dygraphs: one span of time in all of them, events marked, values read off by hovering.

import { History } from "./history.js";
import { hue, patternName } from "./palette.js";
import { number, sum } from "./table.js";

const REDRAW = 500; // ms
const RETELL = 1000; // ms between two values in words while no plot is on the screen
const LEAST_GAP = 3; // pixels between two marks of a kind
const MOST_LINKS = 20; // lines; with more links, the mean of each sender's
// What is told of in an event's mark; of the rest whole lines.
export const MARKS = {
  contact_begin: "contact", contact_end: "contact", authority: "authority", release: "authority", drive: "none", drive_end: "none",
  knob: "setting", netem: "setting", pause: "setting", pause_end: "setting", push: "setting", refused: "setting",
};
const DASHES = {
  plain: null, stripes: [8, 3], dots: [2, 3], grid: [8, 3, 2, 3],
  bars: [14, 3], rings: [2, 6], steps: [14, 3, 2, 3], checks: [5, 5],
};

// Each: title, unit, digits, what the lines are, and their values in a point.
const PLOTS = [
  {
    title: "Inconsistency of each peer's view",
    help: "how far everything in that view is from where its authority has it, all entities summed, metres",
    unit: " m", digits: 2,
    time: measuredAt,
    lines: (h) => h.slots.map(peerLine),
    values: (p, lines) => lines.map((l) => p.peers.get(l.slot)?.combined_m ?? null),
  },
  {
    title: "Updates sent by all peers, by cause",
    help: "updates a second, stacked",
    unit: " /s", digits: 1, stacked: true,
    lines: (h, causes) => causes.map((name, i) => ({ name: name.replaceAll("_", " "), colour: hue(i), dash: null })),
    values: (p, lines) => lines.map((_, i) => sum([...p.peers.values()].map((peer) => peer.updates_per_s?.[i]))),
  },
  {
    title: "How far each confirmed world trails",
    help: "milliseconds behind the live world: what is agreed for good",
    unit: " ms", digits: 0,
    lines: (h) => h.slots.map(peerLine),
    values: (p, lines) => lines.map((l) => p.peers.get(l.slot)?.lag_ms ?? null),
  },
  {
    title: "One-way delay of each link",
    help: "milliseconds, median of the latest datagrams, as the receiver measures it",
    unit: " ms", digits: 0,
    lines: linkLines,
    values: (p, lines) => lines.map((l) => delay(p.peers.get(l.slot)?.delay_ms, l.to)),
  },
];

// Of recordings only: live peers do not tell every tick with its input.
const OF_RECORDINGS = {
  title: "Fidelity error of each peer's view",
  help: "how far bodies are from where the players' deeds alone put them, all bodies summed, metres",
  unit: " m", digits: 2,
  lines: (h) => h.slots.map(peerLine),
  values: (p, lines) => lines.map((l) => p.peers.get(l.slot)?.fidelity_m ?? null),
};

/** Of which second a point's inconsistency is: a tick is measured when it is confirmed, and then it is past. */
function measuredAt(point) {
  const ticks = [...point.peers.values()].map((p) => p.at_tick ?? null).filter((tick) => tick !== null);
  return ticks.length > 0 ? Math.max(...ticks) / 60 : point.time;
}

function peerLine(slot) {
  return { name: `peer ${slot}`, slot, colour: hue(slot), dash: DASHES[patternName(slot)] };
}

function linkLines(history) {
  const n = history.slots.length;
  if (n * (n - 1) > MOST_LINKS) return history.slots.map((slot) => ({ ...peerLine(slot), name: `peer ${slot}, mean`, to: null }));
  // The colour of who sends, and the dashes of who receives.
  const lines = history.slots.flatMap((slot) => history.slots.map((to, i) => (
    { name: `${slot} → ${to}`, slot, to, colour: hue(slot), dash: Object.values(DASHES)[i] }
  )));
  return lines.filter((l) => l.to !== l.slot);
}

function delay(delays, to) {
  if (!delays) return null;
  if (to !== null) return delays[to] ?? null;
  const known = Object.values(delays).filter((d) => d !== null);
  return known.length > 0 ? sum(known) / known.length : null;
}

export class Plots {
  constructor(folder, session, theme, events) {
    // Values are read off below the plots; the legend of dygraphs needs styles that the page's policy forbids.
    Dygraph.PLUGINS = Dygraph.PLUGINS.filter((plugin) => plugin !== Dygraph.Plugins.Legend);
    this.folder = folder;
    this.session = session;
    this.theme = theme;
    this.events = events;
    this.history = new History();
    this.span = 60; // s that are shown when nothing is selected
    this.selected = null; // [from, to] in s
    this.sought = () => {}; // a time was clicked on in a recording
    this.charts = PLOTS.map((plot) => new Chart(plot, folder, this));
    this.shown = true;
    this.toldAt = 0;
    new IntersectionObserver((e) => { this.shown = e.at(-1).isIntersecting; }).observe(folder);
    // A hidden card has no width; a chart keeps the size that it had.
    this.resized = new ResizeObserver((entries) => {
      for (const e of entries) if (e.contentRect.width > 0) e.target.chart.graph?.resize();
    });
    for (const chart of this.charts) this.resized.observe(chart.box);
    setInterval(() => this.redraw(), REDRAW);
  }

  begin() {
    this.history.clear();
    this.selected = null;
    this.selectionChanged?.(false);
    if (this.session.replayed() && this.charts.every((chart) => chart.plot !== OF_RECORDINGS)) {
      this.charts.push(new Chart(OF_RECORDINGS, this.folder, this));
      this.resized.observe(this.charts.at(-1).box);
    }
  }

  add(series) {
    this.history.add(series);
  }

  /** Shows the newest `span` seconds again, or everything for Infinity. */
  follow(span) {
    this.span = span;
    this.select(null);
  }

  select(window) {
    this.selected = window;
    this.selectionChanged?.(window !== null);
    this.redraw();
  }

  window() {
    if (this.selected) return this.selected;
    const { points } = this.history;
    if (points.length === 0) return [0, this.span === Infinity ? 60 : this.span];
    const newest = points.at(-1).time;
    if (this.session.replayed() || this.span === Infinity) return [points[0].time, Math.max(newest, points[0].time + 1)];
    // At the start the line begins at the left, and only then the window moves.
    const from = Math.max(newest - this.span, points[0].time);
    return [from, Math.max(newest, from + Math.min(this.span, 10))];
  }

  redraw() {
    if (document.hidden || this.history.points.length === 0) return;
    if (!this.shown) {
      this.tell();
      return;
    }
    const window = this.window();
    for (const chart of this.charts) chart.draw(window);
  }

  /** Values in words alone: screen readers read them wherever the page is scrolled to. */
  tell() {
    if (performance.now() - this.toldAt < RETELL) return;
    this.toldAt = performance.now();
    for (const chart of this.charts) {
      chart.refreshRows();
      chart.readOut();
    }
  }

  /** A time is pointed at in a chart; null: none any more. */
  hover(time, chart) {
    for (const c of this.charts) {
      c.time = time;
      if (c !== chart && time !== null) c.graph?.setSelection(c.rowAt(time));
      if (c !== chart && time === null) c.graph?.clearSelection();
      c.readOut();
    }
  }

  recolour() {
    for (const chart of this.charts) chart.recolour();
    this.redraw();
  }
}

class Chart {
  constructor(plot, folder, plots) {
    this.plot = plot;
    this.plots = plots;
    this.time = null; // that is pointed at
    this.rows = [];
    const figure = document.createElement("figure");
    const title = document.createElement("figcaption");
    const strong = document.createElement("strong");
    strong.textContent = plot.title;
    title.append(strong, ` ${plot.help}`);
    this.box = document.createElement("div");
    this.box.className = "chart";
    this.box.chart = this;
    this.box.setAttribute("role", "img");
    this.box.setAttribute("aria-label", `${plot.title}. Its values are below.`);
    this.values = document.createElement("p");
    this.values.className = "values";
    figure.append(title, this.box, this.values);
    folder.append(figure);
  }

  /** Rows of numbers for dygraphs; made anew when lines come or old points go. */
  refreshRows() {
    const { history, session } = this.plots;
    if (this.version !== history.version) {
      this.version = history.version;
      this.lines = this.plot.lines(history, session.hello?.causes ?? []);
      this.rows = [];
    }
    for (let i = this.rows.length; i < history.points.length; ++i) {
      const p = history.points[i];
      // Rows have to ascend, also where nothing is known of one.
      const time = Math.max(this.plot.time?.(p) ?? p.time, this.rows.at(-1)?.[0] ?? 0);
      this.rows.push([time, ...this.plot.values(p, this.lines)]);
    }
  }

  draw(window) {
    this.refreshRows();
    if (this.lines.length === 0) return;
    // In a box that is not shown dygraphs would take, and keep, a size of its own.
    if (this.box.clientWidth > 0) this.drawIn(window);
    this.readOut();
  }

  drawIn(window) {
    const options = {
      file: this.rows,
      labels: ["time", ...this.lines.map((l) => l.name)],
      colors: this.lines.map((l) => l.colour),
      series: Object.fromEntries(this.lines.map((l) => [l.name, { strokePattern: l.dash }])),
      dateWindow: window,
    };
    if (this.graph) this.graph.updateOptions(options);
    else this.make(options);
  }

  make(options) {
    const { plot, plots } = this;
    const model = { ...Dygraph.defaultInteractionModel, dblclick: () => plots.select(null) };
    // Fingers shall scroll the page.
    for (const touch of ["touchstart", "touchmove", "touchend"]) delete model[touch];
    this.graph = new Dygraph(this.box, options.file, {
      ...options,
      ...this.colours(),
      interactionModel: model,
      stackedGraph: Boolean(plot.stacked),
      fillGraph: Boolean(plot.stacked),
      connectSeparatedPoints: false,
      includeZero: true,
      strokeWidth: 1.5,
      highlightCircleSize: 3,
      animatedZooms: false,
      rightGap: 8,
      axes: {
        x: { axisLabelFormatter: clock, pixelsPerLabel: 60, axisLabelWidth: 50 },
        // Not in exponents.
        y: { axisLabelFormatter: (value) => String(Math.round(value * 1e4) / 1e4), axisLabelWidth: 44, pixelsPerLabel: 30 },
      },
      underlayCallback: (ctx, area, graph) => this.markEvents(ctx, area, graph),
      zoomCallback: (from, to) => plots.select([from, to]),
      highlightCallback: (e, x) => plots.hover(x, this),
      unhighlightCallback: () => plots.hover(null, this),
      clickCallback: (e, x) => plots.sought(x),
    });
  }

  colours() {
    const { colours } = this.plots.theme;
    return { gridLineColor: colours.grid, axisLineColor: colours.quiet };
  }

  recolour() {
    this.graph?.updateOptions(this.colours(), true);
  }

  /** Lines for what happened: short ones below for contacts, above for authority and settings, whole ones for the rest. */
  markEvents(ctx, area, graph) {
    const { colours } = this.plots.theme;
    const [from, to] = graph.xAxisRange();
    const x = (time) => Math.round(graph.toDomXCoord(time)) + 0.5;
    ctx.save();
    ctx.lineWidth = 1;
    for (const [height, top, colour, wanted] of [
      [7, false, colours.quiet, (k) => MARKS[k] === "contact"],
      [7, true, colours.predicted, (k) => MARKS[k] === "authority"],
      [12, true, colours.quiet, (k) => MARKS[k] === "setting"],
      [area.h, true, colours.alarm, (k) => MARKS[k] === undefined],
    ]) {
      ctx.strokeStyle = colour;
      ctx.beginPath();
      let last = -Infinity; // a dozen events at a time shall be one line, not a bar
      for (const e of this.plots.events.list) {
        if (e.time < from || e.time > to || !wanted(e.kind) || x(e.time) - last < LEAST_GAP) continue;
        last = x(e.time);
        const y = top ? area.y : area.y + area.h - height;
        ctx.moveTo(x(e.time), y);
        ctx.lineTo(x(e.time), y + height);
      }
      ctx.stroke();
    }
    const { timeline } = this.plots.session;
    if (this.plots.session.replayed() && timeline) {
      ctx.strokeStyle = colours.text;
      ctx.lineWidth = 2;
      ctx.beginPath();
      ctx.moveTo(x(timeline.tick / 60), area.y);
      ctx.lineTo(x(timeline.tick / 60), area.y + area.h);
      ctx.stroke();
    }
    ctx.restore();
  }

  /** Values under the pointer, else the newest, in words. */
  readOut() {
    const row = this.rows[this.time === null ? this.positionRow() : this.rowAt(this.time)];
    if (!row || !this.lines) return;
    const parts = this.lines.map((line, i) => {
      const value = row[i + 1];
      const item = document.createElement("span");
      item.style.setProperty("--line", drawn(line));
      item.textContent = `${line.name} ${number(value, this.plot.digits, this.plot.unit)}`;
      return item;
    });
    const when = document.createElement("b");
    when.textContent = this.time === null ? clock(row[0]) : `${clock(this.time)}${near(this.plots.events, this.time)}`;
    this.values.replaceChildren(when, ...parts);
  }

  positionRow() {
    const { session } = this.plots;
    if (!session.replayed() || !session.timeline) return this.rows.length - 1;
    return this.rowAt(session.timeline.tick / 60);
  }

  /** The row at a time, else the next one, else the last. */
  rowAt(time) {
    const i = this.rows.findIndex((r) => r[0] >= time);
    return i < 0 ? this.rows.length - 1 : i;
  }
}

/** A line's colour and dashes, as a background. */
function drawn({ colour, dash }) {
  let at = 0;
  const stops = (dash ?? [1, 0]).map((length, i) => `${i % 2 ? "transparent" : colour} ${at}px ${at += length}px`);
  return `repeating-linear-gradient(90deg, ${stops.join(", ")})`;
}

/** What happened round a time, for the values under the pointer. */
function near(events, time) {
  const found = events.list.filter((e) => Math.abs(e.time - time) < 0.25);
  if (found.length === 0) return "";
  return ` · ${events.words(found[0])}${found.length > 1 ? ` and ${found.length - 1} more` : ""} ·`;
}

export function clock(seconds) {
  const s = Math.max(0, seconds);
  const digits = Math.abs(s - Math.round(s)) > 0.01 ? 1 : 0;
  const rest = (s % 60).toFixed(digits);
  return `${Math.floor(s / 60)}:${rest.padStart(digits ? 4 : 2, "0")}`;
}
