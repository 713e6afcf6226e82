// Mouse, pen and fingers on the canvases. A click takes the wheel of a peer; on the driven view a held button steers, on
// any other view it pans. The right button, the middle one or Shift pan everywhere; wheel and two fingers zoom.

const STILL = 6; // pixels within which a press is a click

export class Pointers {
  constructor(views, camera, driver) {
    this.views = views;
    this.camera = camera;
    this.driver = driver;
    this.down = new Map();
    this.clicked = () => {};
  }

  /** Listens on a view's canvas. */
  watch(tile) {
    const { canvas } = tile;
    canvas.addEventListener("pointerdown", (e) => this.press(tile, e));
    canvas.addEventListener("pointermove", (e) => this.move(tile, e));
    canvas.addEventListener("pointerup", (e) => this.lift(tile, e, true));
    canvas.addEventListener("pointercancel", (e) => this.lift(tile, e, false));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => this.wheel(tile, e), { passive: false });
    canvas.addEventListener("keydown", (e) => this.key(tile, e));
  }

  key(tile, event) {
    if (event.key === "Enter") this.clicked(tile.slot);
    else if (event.key === "+" || event.key === "=") this.camera.zoomAbout(this.camera, 1.25);
    else if (event.key === "-") this.camera.zoomAbout(this.camera, 0.8);
    else if (event.key === "0") this.camera.reset();
    else if (event.key !== " ") return;
    event.preventDefault(); // Space would scroll the page away
  }

  wheel(tile, event) {
    // The page shall scroll too: only with the pointer on a view that was clicked on, or with Ctrl.
    if (!event.ctrlKey && document.activeElement !== tile.canvas && this.driver.slot !== tile.slot) return;
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    this.camera.zoomAbout(this.views.pointAt(tile, event), Math.exp(-event.deltaY * lines * 0.0015));
  }

  press(tile, event) {
    const touch = event.pointerType === "touch";
    const steers = this.driver.slot === tile.slot && event.button === 0 && !event.shiftKey;
    this.down.set(event.pointerId, { x: event.clientX, y: event.clientY, startX: event.clientX, startY: event.clientY, steers, touch, moved: false });
    if (!touch || steers) tile.canvas.setPointerCapture(event.pointerId);
    if (this.down.size > 1) {
      // A second finger: zoom, whatever the first was for.
      for (const p of this.down.values()) p.steers = false;
      this.driver.follow(null);
    } else if (steers) {
      this.driver.follow(this.views.pointAt(tile, event));
    }
    if (event.button === 1) event.preventDefault();
  }

  move(tile, event) {
    const p = this.down.get(event.pointerId);
    if (!p) return;
    const [dx, dy] = [event.clientX - p.x, event.clientY - p.y];
    if (Math.hypot(event.clientX - p.startX, event.clientY - p.startY) > STILL) p.moved = true;
    if (this.down.size === 2) {
      this.pinch(tile, event, p);
    } else if (p.steers) {
      this.driver.follow(this.views.pointAt(tile, event));
    } else if (p.moved && !p.touch) {
      const { scale } = this.camera.fit(tile.width, tile.height);
      this.camera.pan(-dx / scale, dy / scale);
    }
    p.x = event.clientX;
    p.y = event.clientY;
  }

  pinch(tile, event, p) {
    const [other] = [...this.down.entries()].filter(([id]) => id !== event.pointerId).map(([, q]) => q);
    const before = Math.hypot(p.x - other.x, p.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    const { scale } = this.camera.fit(tile.width, tile.height);
    this.camera.pan(-(event.clientX - p.x) / 2 / scale, (event.clientY - p.y) / 2 / scale);
    const middle = { clientX: (event.clientX + other.x) / 2, clientY: (event.clientY + other.y) / 2 };
    if (before > 0) this.camera.zoomAbout(this.views.pointAt(tile, middle), after / before);
  }

  lift(tile, event, meant) {
    const p = this.down.get(event.pointerId);
    this.down.delete(event.pointerId);
    if (!p) return;
    if (p.steers) this.driver.follow(null);
    else if (meant && !p.moved && event.button === 0 && this.down.size === 0) this.clicked(tile.slot);
  }
}
