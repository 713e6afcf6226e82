// Colours for up to 32 peers that people with any colour vision can tell apart: eight hues of the Okabe-Ito set, and from
// the ninth peer on a pattern as well. The number of the avatar always says the same.

const HUES = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9", "#cc79a7", "#b9a90b", "#8a6d5b"];
const PATTERNS = ["plain", "stripes", "dots", "grid"];
const NOBODY = 255;

/** The hue of a slot, 0 .. 31. */
export function hue(slot) {
  return HUES[slot % HUES.length];
}

export function patternName(slot) {
  return PATTERNS[Math.floor(slot / HUES.length) % PATTERNS.length];
}

/** Black or white, whichever is read better on the hue of a slot. */
export function ink(slot) {
  const [r, g, b] = [1, 3, 5].map((i) => linear(parseInt(hue(slot).slice(i, i + 2), 16) / 255));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.22 ? "#000" : "#fff";
}

function linear(c) {
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** What a canvas fills with for entities under a slot's authority; `colours` are those of the theme. */
export class Fills {
  constructor(colours) {
    this.colours = colours;
    this.cache = new Map();
  }

  of(slot) {
    if (slot === NOBODY) return this.colours.nobody;
    let fill = this.cache.get(slot);
    if (fill === undefined) {
      fill = makeFill(slot);
      this.cache.set(slot, fill);
    }
    return fill;
  }
}

function makeFill(slot) {
  const name = patternName(slot);
  if (name === "plain") return hue(slot);
  const tile = document.createElement("canvas");
  tile.width = tile.height = 8;
  const ctx = tile.getContext("2d");
  ctx.fillStyle = hue(slot);
  ctx.fillRect(0, 0, 8, 8);
  ctx.fillStyle = ctx.strokeStyle = ink(slot);
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  if (name === "stripes") {
    for (const d of [-8, 0, 8]) {
      ctx.moveTo(d - 1, 9);
      ctx.lineTo(d + 9, -1);
    }
    ctx.stroke();
  } else if (name === "dots") {
    ctx.arc(4, 4, 1.6, 0, 7);
    ctx.fill();
  } else {
    ctx.moveTo(4, 0);
    ctx.lineTo(4, 8);
    ctx.moveTo(0, 4);
    ctx.lineTo(8, 4);
    ctx.stroke();
  }
  return ctx.createPattern(tile, "repeat");
}
