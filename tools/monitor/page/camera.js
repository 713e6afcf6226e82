// One camera for all views: which part of the world they show. Metres of the world have y up, pixels have y down.

const MARGIN = 0.06; // of the play area, kept free round it
const [FARTHEST, CLOSEST] = [0.5, 40]; // zoom

export class Camera {
  constructor() {
    this.lower = { x: 0, y: 0 };
    this.upper = { x: 20, y: 15 };
    this.reset();
  }

  /** Shows the whole play area between two corners, in metres. */
  setArea(lower, upper) {
    this.lower = lower;
    this.upper = upper;
    this.reset();
  }

  reset() {
    this.x = (this.lower.x + this.upper.x) / 2;
    this.y = (this.lower.y + this.upper.y) / 2;
    this.zoom = 1; // 1: the play area fits
    this.follow = null; // slot of the avatar that stays in the middle
  }

  /** Width over height of the play area: what a view should be shaped like. */
  aspect() {
    return (this.upper.x - this.lower.x) / (this.upper.y - this.lower.y);
  }

  /** The transform for a canvas of that many pixels. */
  fit(width, height) {
    const w = (this.upper.x - this.lower.x) * (1 + MARGIN);
    const h = (this.upper.y - this.lower.y) * (1 + MARGIN);
    const scale = Math.min(width / w, height / h) * this.zoom;
    return { scale, left: width / 2 - this.x * scale, top: height / 2 + this.y * scale };
  }

  /** Zooms by a factor about a point of the world, which stays where it is on the screen. */
  zoomAbout(point, factor) {
    const zoom = clamp(this.zoom * factor, FARTHEST, CLOSEST);
    const real = zoom / this.zoom;
    if (this.follow === null) {
      this.x = point.x + (this.x - point.x) / real;
      this.y = point.y + (this.y - point.y) / real;
    }
    this.zoom = zoom;
  }

  /** Moves the picture by metres; ends following. */
  pan(dx, dy) {
    this.follow = null;
    this.show(this.x + dx, this.y + dy, this.zoom);
  }

  /** Shows that point in the middle, or the nearest that there is. */
  show(x, y, zoom) {
    this.x = clamp(x, this.lower.x, this.upper.x);
    this.y = clamp(y, this.lower.y, this.upper.y);
    this.zoom = clamp(zoom, FARTHEST, CLOSEST);
  }
}

function clamp(v, low, high) {
  return Math.min(Math.max(v, low), high);
}

/** The point of the world under a pixel. */
export function toWorld(fit, px, py) {
  return { x: (px - fit.left) / fit.scale, y: (fit.top - py) / fit.scale };
}
