// Pictures of avatars, painted once for each size: writing a number costs many times as much as copying it, and with 22
// avatars in 12 views there are hundreds of them in every frame.

import { hue, ink, patternName } from "./palette.js";

const TURN = Math.PI * 2;
const MOST = 400; // kept; zooming makes new ones

export class Sprites {
  constructor(colours, fills) {
    this.colours = colours;
    this.fills = fills;
    this.kept = new Map();
  }

  /** The disc of an avatar `r` pixels in radius, sharp at that many canvas pixels a pixel; the middle is the position. */
  of(slot, r, own, sharp) {
    const key = `${slot} ${r.toFixed(1)} ${own} ${sharp}`;
    let picture = this.kept.get(key);
    if (!picture) {
      if (this.kept.size >= MOST) this.kept.clear();
      picture = this.paint(slot, r, own, sharp);
      this.kept.set(key, picture);
    }
    return picture;
  }

  paint(slot, r, own, sharp) {
    const half = Math.ceil(r + 3);
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = half * 2 * sharp;
    const ctx = canvas.getContext("2d");
    ctx.setTransform(sharp, 0, 0, sharp, half * sharp, half * sharp);
    ctx.beginPath();
    ctx.arc(0, 0, r, 0, TURN);
    ctx.fillStyle = this.fills.of(slot);
    ctx.fill();
    ctx.lineWidth = own ? 3 : 1.5;
    ctx.strokeStyle = own ? this.colours.own : this.colours.outline;
    ctx.stroke();
    if (patternName(slot) !== "plain") {
      ctx.fillStyle = hue(slot);
      ctx.beginPath();
      ctx.arc(0, 0, r * 0.72, 0, TURN);
      ctx.fill();
    }
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.font = `bold ${Math.round(Math.min(Math.max(r * 1.1, 9), 40))}px system-ui, sans-serif`;
    ctx.fillStyle = ink(slot);
    ctx.fillText(String(slot), 0, 0.5);
    return { canvas, half };
  }
}
