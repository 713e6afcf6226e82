// The canvases: one for each peer side by side, or all peers overlaid in one, or one of them large. Everything is drawn in
// one pass for each frame of the screen and from one moment of the session, so that views can be compared.

import { toWorld } from "./camera.js";
import { drawAvatars, drawBackground, drawBodies, drawGhosts, drawIntent } from "./draw.js";
import { Fills, hue } from "./palette.js";
import { clock } from "./plots.js";
import { AUTHORITY, CONFIRMED, PREDICTED, SHOWN } from "./samples.js";
import { Sprites } from "./sprites.js";

const OVERLAY = -1;
const AGREED = 255; // the view of a capture
const SILENT_MS = 1500;
const SHARPEST = 2; // canvas pixels per CSS pixel: more costs time and shows nothing
const BACKGROUNDS = 4; // kept: all views are of one size, or one is larger
const CAPTION = 40; // pixels below a picture
const LEAST = 80; // pixels of a picture's width, also while the page itself has none
const SMALL = 300; // pixels of a picture's width below which its caption has fewer buttons
const TINY = 230; // and below which they have a row of their own
const TINY_CAPTION = 60;
const BELOW = 44; // pixels below the pictures, for what follows to be seen
const ONE_ROW = 0.9; // of the width that pictures would have in several rows
const PAINTED_WHOLE = 600; // bodies times views above which pixels are not doubled

export class Views {
  constructor(grid, session, camera, theme) {
    this.grid = grid;
    this.session = session;
    this.camera = camera;
    this.theme = theme;
    this.mode = "side";
    this.large = null; // slot that is shown large in mode "one"
    this.ghosts = { authority: true, predicted: false, confirmed: false };
    this.driven = null;
    this.called = ""; // what distinguishes these pictures from others on the page, for screen readers
    this.tiles = new Map();
    this.onTile = () => {}; // a tile was made: whoever listens to pointers wants to know
    this.onAction = () => {};
    this.reserved = () => 0; // pixels that are to be kept free below the pictures
    this.beside = () => false; // the tour stands beside the pictures, as the screen is low: all shall be seen at once
    this.visible = new IntersectionObserver((entries) => {
      for (const e of entries) e.target.tile.visible = e.isIntersecting;
    });
    this.recolour();
    this.resized = new ResizeObserver(() => this.layOut());
    this.resized.observe(grid);
    addEventListener("resize", () => this.layOut());
  }

  recolour() {
    this.fills = new Fills(this.theme.colours);
    this.sprites = new Sprites(this.theme.colours, this.fills);
    this.forgetBackgrounds();
  }

  /** Another scene, or other colours. */
  forgetBackgrounds() {
    this.backgrounds = new Map(); // by size in pixels
  }

  /** Which slots have a canvas now. */
  slots() {
    const { session } = this;
    if (session.hello && session.hello.mode === "capture") return [AGREED];
    const there = session.present().map((p) => p.slot);
    if (this.mode === "overlay") return there.length > 0 ? [OVERLAY] : [];
    if (this.mode === "one") {
      const slot = there.includes(this.large) ? this.large : there[0];
      return slot === undefined ? [] : [slot];
    }
    return there;
  }

  /** Makes and removes canvases as peers come and go. */
  update() {
    const wanted = this.session.scene ? this.slots() : [];
    for (const [slot, tile] of this.tiles) {
      if (wanted.includes(slot)) continue;
      this.visible.unobserve(tile.canvas);
      tile.figure.remove();
      this.tiles.delete(slot);
    }
    for (const slot of wanted) {
      if (!this.tiles.has(slot)) this.tiles.set(slot, this.makeTile(slot));
    }
    const order = [...this.tiles.keys()].sort((a, b) => a - b);
    order.forEach((slot, i) => {
      const { figure } = this.tiles.get(slot);
      if (this.grid.children[i] !== figure) this.grid.insertBefore(figure, this.grid.children[i] ?? null);
    });
    for (const [slot, tile] of this.tiles) this.describe(slot, tile);
    this.layOut();
  }

  makeTile(slot) {
    const figure = document.createElement("figure");
    const canvas = document.createElement("canvas");
    const caption = document.createElement("figcaption");
    const name = document.createElement("strong");
    const said = document.createElement("span");
    const buttons = document.createElement("span");
    said.className = "said";
    buttons.className = "buttons";
    name.textContent = { [OVERLAY]: "All peers, one over the other", [AGREED]: "The agreed world, from the capture" }[slot] ?? `Peer ${slot}`;
    canvas.tabIndex = 0;
    // Keys steer in it: a screen reader shall hand them on.
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-roledescription", "picture");
    caption.append(name, said, buttons);
    figure.append(canvas, caption);
    figure.dataset.slot = slot;
    if (slot >= 0 && slot !== AGREED) {
      figure.style.setProperty("--hue", hue(slot));
      for (const [action, sign, title] of [
        ["drive", "Drive", `Steer the avatar of peer ${slot}`],
        ["follow", "Follow", `Keep avatar ${slot} in the middle of every view`],
        ["large", "Enlarge", `Show peer ${slot} alone, or all again`],
      ]) {
        const b = document.createElement("button");
        b.type = "button";
        b.className = action;
        b.textContent = sign;
        b.title = title;
        b.addEventListener("click", () => this.onAction(action, slot));
        buttons.append(b);
      }
    }
    const tile = { slot, figure, canvas, said, buttons, visible: true, ctx: canvas.getContext("2d", { alpha: false }) };
    canvas.tile = tile;
    this.visible.observe(canvas);
    this.onTile(tile);
    return tile;
  }

  /** What a canvas's caption says in words, and its buttons. */
  describe(slot, tile) {
    const { session } = this;
    const peer = session.peer(slot);
    const driven = this.driven === slot;
    tile.figure.classList.toggle("driven", driven);
    if (!peer) {
      if (slot === OVERLAY) tile.said.textContent = "outlines in a peer's colour: what its picture shows elsewhere";
      tile.canvas.setAttribute("aria-label", tile.figure.querySelector("strong").textContent);
      return;
    }
    const error = session.error(peer);
    const stale = session.offline !== null && !session.replayed();
    const words = stale ? ["not connected"] : [];
    if (peer.state === "silent") words.push("silent: no news for 1 s");
    if (peer.input === "none") words.push("spectator");
    if (peer.paused) words.push("paused");
    if (peer.links.some((l) => l.cut)) words.push("cut off");
    if (peer.driven === "other") words.push("driven by somebody else");
    const at = session.errorAt(peer);
    const off = stale ? [] : session.isApart(peer) ? ["error not known"] : error === null ? [] : [`${metres(error)} off${at === null ? "" : ` at ${clock(at)}`}`];
    tile.said.textContent = [...words, ...off].join(" · ");
    if (driven) words.push("you drive");
    tile.said.title = "off: how far everything in this view is from where its authority has it, all entities summed; live, the mean since the last point of the plots, of ticks that are confirmed; in a recording, of this very moment; not known while this peer is apart from the others";
    const drive = tile.buttons.querySelector(".drive");
    drive.hidden = !driven && !session.drivable().some((p) => p.slot === slot);
    drive.textContent = driven ? "Let go" : "Drive";
    // Without what changes all the time: a screen reader says the name of what has the focus whenever it changes.
    const name = [`${this.called}View of peer ${slot}`, words.join(", "), drive.hidden || driven ? "" : "Enter drives its avatar"];
    tile.canvas.setAttribute("aria-label", `${name.filter(Boolean).join(". ")}.`);
    const follow = tile.buttons.querySelector(".follow");
    follow.setAttribute("aria-pressed", this.camera.follow === slot);
    follow.hidden = peer.input === "none";
    const large = tile.buttons.querySelector(".large");
    large.textContent = this.mode === "one" ? "All" : "Enlarge";
    large.hidden = this.session.present().length < 2;
    for (const b of tile.buttons.children) b.setAttribute("aria-label", `${b.textContent}, peer ${slot}`);
  }

  /** Sizes of all canvases. */
  layOut() {
    const count = this.tiles.size;
    if (count === 0) return;
    const aspect = Math.min(Math.max(this.camera.aspect(), 0.5), 2.6);
    const style = getComputedStyle(this.grid);
    const gap = parseFloat(style.columnGap) || 0;
    const width = this.grid.clientWidth;
    const narrow = width < 600 && !this.beside();
    const big = narrow && count > 2 ? this.bigOne() : null;
    let best = { columns: 1, w: Math.floor(width) };
    if (big !== null) {
      const columns = Math.min(3, count - 1);
      best = { columns, w: Math.floor((width - gap * (columns - 1)) / columns) };
    } else if (!narrow) {
      best = this.widest(count, gap, aspect);
    }
    best.w = Math.max(best.w, LEAST);
    this.grid.style.gridTemplateColumns = `repeat(${best.columns}, ${best.w}px)`;
    this.sharp = Math.min(devicePixelRatio || 1, this.session.scene.bodies.length * count > PAINTED_WHOLE ? 1 : SHARPEST);
    let resized = false;
    for (const tile of this.tiles.values()) {
      const alone = tile.slot === big;
      const w = alone ? Math.max(Math.floor(width), LEAST) : best.w;
      tile.figure.classList.toggle("small", w < SMALL);
      tile.figure.classList.toggle("tiny", w < TINY);
      tile.figure.classList.toggle("big", alone);
      tile.width = w;
      tile.height = Math.round(w / aspect);
      const [pw, ph] = [Math.round(w * this.sharp), Math.round(tile.height * this.sharp)];
      if (tile.canvas.width !== pw || tile.canvas.height !== ph) {
        tile.canvas.width = pw;
        tile.canvas.height = ph;
        tile.canvas.style.width = `${w}px`;
        tile.canvas.style.height = `${tile.height}px`;
        resized = true;
      }
    }
    // A canvas is empty when its size has changed; nobody shall see that.
    if (resized) this.draw();
  }

  /** On a narrow screen one picture has the whole width: the driven one, the one touched last, or the first. */
  bigOne() {
    return [this.driven, this.large, ...[...this.tiles.keys()].sort((a, b) => a - b)].find((slot) => slot !== null && this.tiles.has(slot));
  }

  /** Columns, and the width of a picture in pixels, that make the pictures largest in the space there is. */
  widest(count, gap, aspect) {
    const width = this.grid.clientWidth;
    const below = this.beside() ? 0 : BELOW + this.reserved();
    const height = Math.max(innerHeight - this.grid.getBoundingClientRect().top - scrollY - below, 200);
    let best = { columns: 1, w: 0 };
    for (let columns = 1; columns <= count; ++columns) {
      const rows = Math.ceil(count / columns);
      const across = (width - gap * (columns - 1)) / columns;
      const fitting = (caption) => Math.floor(Math.min(across, ((height - gap * (rows - 1)) / rows - caption) * aspect));
      const w = fitting(fitting(CAPTION) < TINY ? TINY_CAPTION : CAPTION);
      // Rather in one row, if that costs little: what follows is then in view.
      if (w > best.w || (rows === 1 && w > best.w * ONE_ROW)) best = { columns, w };
    }
    return best;
  }

  /** Draws every canvas that is on the screen. */
  draw() {
    if (!this.session.scene) return;
    const { samples, scene } = this.session;
    if (this.camera.follow !== null) {
      const all = samples.sample(this.camera.follow, SHOWN);
      const id = scene.bodies.length + this.camera.follow;
      if (all && all.world.flags[id] & 1) {
        this.camera.x = all.world.x[id];
        this.camera.y = all.world.y[id];
      }
    }
    for (const tile of this.tiles.values()) {
      if (tile.visible) this.drawTile(tile);
    }
  }

  drawTile(tile) {
    const { ctx, slot } = tile;
    const { samples, scene } = this.session;
    const fit = this.camera.fit(tile.width, tile.height);
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.paintedBackground(tile, fit), 0, 0);
    ctx.setTransform(this.sharp, 0, 0, this.sharp, 0, 0);
    if (slot === OVERLAY) {
      this.drawOverlay(tile, fit);
      return;
    }
    const sample = samples.sample(slot, slot === AGREED ? CONFIRMED : SHOWN);
    if (!sample) {
      this.say(tile, "no news yet");
      return;
    }
    const look = this.look(slot);
    drawBodies(ctx, fit, scene, sample, look);
    drawAvatars(ctx, fit, scene, sample, look);
    this.drawGhostsOf(ctx, fit, slot, sample);
    drawIntent(ctx, fit, scene, sample, look);
    const stands = this.session.replayed() ? false : samples.age(slot, SHOWN) > SILENT_MS;
    if (sample.paused) this.say(tile, "paused");
    else if (stands) this.say(tile, "silent: no news from this peer");
  }

  look(slot) {
    return {
      colours: this.theme.colours,
      fills: this.fills,
      sprites: this.sprites,
      own: slot,
      asleep: 0.55,
      sharp: this.sharp,
    };
  }

  drawGhostsOf(ctx, fit, slot, sample) {
    const { samples, scene } = this.session;
    const { colours } = this.theme;
    const ghosts = [];
    if (this.ghosts.predicted) ghosts.push([samples.sample(slot, PREDICTED), { colour: colours.predicted, dash: [2, 2], lines: false, least: 0.01, width: 1 }]);
    if (this.ghosts.confirmed) ghosts.push([samples.sample(slot, CONFIRMED), { colour: colours.confirmed, dash: [6, 3], lines: false, least: 0.01, width: 1 }]);
    if (this.ghosts.authority) ghosts.push([samples.sample(AGREED, AUTHORITY), { colour: colours.difference, dash: [], lines: true, least: 0.03, leastAvatar: 0.1, width: 2.5 }]);
    for (const [ghost, style] of ghosts) {
      if (ghost) drawGhosts(ctx, fit, scene, sample, ghost.world, style);
    }
  }

  /** The authority's world, and in each peer's colour what that peer's view has elsewhere. */
  drawOverlay(tile, fit) {
    const { samples, scene } = this.session;
    const { ctx } = tile;
    const truth = samples.sample(AGREED, AUTHORITY);
    if (!truth) {
      this.say(tile, "no news yet");
      return;
    }
    const look = this.look(OVERLAY);
    drawBodies(ctx, fit, scene, truth, look);
    drawAvatars(ctx, fit, scene, truth, look);
    for (const peer of this.session.present()) {
      const sample = samples.sample(peer.slot, SHOWN);
      if (sample) drawGhosts(ctx, fit, scene, truth, sample.world, { colour: hue(peer.slot), dash: [], lines: true, least: 0.02, width: 1.5 });
    }
  }

  say(tile, word) {
    const { ctx } = tile;
    const font = (px) => { ctx.font = `600 ${px}px system-ui, sans-serif`; };
    font(15);
    const wide = ctx.measureText(word).width + 24;
    const [short] = word.split(":");
    if (wide > tile.width && short !== word) {
      this.say(tile, short);
      return;
    }
    if (wide > tile.width) font(Math.floor((15 * tile.width) / wide));
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    const w = ctx.measureText(word).width + 24;
    ctx.fillStyle = this.theme.colours.outside;
    ctx.globalAlpha = 0.9;
    ctx.fillRect(tile.width / 2 - w / 2, tile.height / 2 - 15, w, 30);
    ctx.globalAlpha = 1;
    ctx.fillStyle = this.theme.colours.text;
    ctx.fillText(word, tile.width / 2, tile.height / 2);
  }

  /** What never moves is painted once for all canvases of a size, and again when the camera moves. */
  paintedBackground(tile, fit) {
    const { width, height } = tile.canvas;
    const size = `${width} ${height}`;
    let kept = this.backgrounds.get(size);
    if (!kept) {
      if (this.backgrounds.size >= BACKGROUNDS) this.backgrounds.clear();
      kept = { canvas: document.createElement("canvas"), of: "" };
      kept.canvas.width = width;
      kept.canvas.height = height;
      this.backgrounds.set(size, kept);
    }
    const of = [fit.scale, fit.left, fit.top].join();
    if (kept.of !== of) {
      kept.of = of;
      const ctx = kept.canvas.getContext("2d", { alpha: false });
      ctx.setTransform(this.sharp, 0, 0, this.sharp, 0, 0);
      drawBackground(ctx, tile.width, tile.height, fit, this.session.scene, this.theme.colours);
    }
    return kept.canvas;
  }

  /** The point of the world under a pointer event on a tile. */
  pointAt(tile, event) {
    const box = tile.canvas.getBoundingClientRect();
    return toWorld(this.camera.fit(tile.width, tile.height), event.clientX - box.left, event.clientY - box.top);
  }
}

export function metres(m) {
  return m < 0.0995 ? `${Math.round(m * 100)} cm` : m < 9.95 ? `${m.toFixed(1)} m` : `${Math.round(m)} m`;
}
