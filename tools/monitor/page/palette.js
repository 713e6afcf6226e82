// Colours for up to 64 peers that people with any colour vision can tell apart: eight hues after the Okabe-Ito set, and
// from the ninth peer on a pattern as well. The number of the avatar always says the same. The plots of the other programs
// have the same hues (tools/plot/palette.cpp); a test compares the two.

const HUES = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9", "#cc79a7", "#8250df", "#8a6d5b"];
const PATTERNS = ["plain", "stripes", "dots", "grid", "bars", "rings", "steps", "checks"];
const NOBODY = 255;

/** The hue of a slot, 0 .. 63. */
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

// On a tile of 8 by 8, repeated.
const DRAW = {
  stripes: (ctx) => lines(ctx, [-8, 0, 8].map((d) => [d - 1, 9, d + 9, -1])),
  dots: (ctx) => {
    ctx.arc(4, 4, 1.6, 0, 7);
    ctx.fill();
  },
  grid: (ctx) => lines(ctx, [[4, 0, 4, 8], [0, 4, 8, 4]]),
  bars: (ctx) => lines(ctx, [[4, 0, 4, 8]]),
  rings: (ctx) => {
    ctx.arc(4, 4, 2.4, 0, 7);
    ctx.stroke();
  },
  steps: (ctx) => lines(ctx, [[0, 4, 8, 4]]),
  checks: (ctx) => {
    ctx.fillRect(0, 0, 4, 4);
    ctx.fillRect(4, 4, 4, 4);
  },
};

function lines(ctx, all) {
  for (const [x, y, to_x, to_y] of all) {
    ctx.moveTo(x, y);
    ctx.lineTo(to_x, to_y);
  }
  ctx.stroke();
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
  DRAW[name](ctx);
  return ctx.createPattern(tile, "repeat");
}
