// What drawing costs: the time between frames and the time spent in one, over the newest ones.

const WINDOW = 240; // frames

export class Meter {
  constructor(element) {
    this.element = element;
    this.gaps = new Float64Array(WINDOW);
    this.costs = new Float64Array(WINDOW);
    this.count = 0;
    this.stats = { frames: 0, fps: 0, frame_ms: 0, frame_ms_p95: 0, gap_ms_p95: 0, bytes: 0, messages: 0 };
    this.saidAt = 0;
  }

  received(bytes) {
    this.stats.bytes += bytes;
    ++this.stats.messages;
  }

  /** `gap`: ms since the frame before; `cost`: ms that this one took. */
  frame(now, gap, cost) {
    this.gaps[this.count % WINDOW] = gap;
    this.costs[this.count % WINDOW] = cost;
    ++this.count;
    ++this.stats.frames;
    if (now - this.saidAt < 1000) return;
    this.saidAt = now;
    this.sumUp();
    this.element.textContent = `${Math.round(this.stats.fps)} fps, ${this.stats.frame_ms.toFixed(1)} ms`;
  }

  sumUp() {
    const n = Math.min(this.count, WINDOW);
    const gaps = this.gaps.slice(0, n).sort();
    const costs = this.costs.slice(0, n).sort();
    const mean = (values) => values.reduce((a, b) => a + b, 0) / n;
    this.stats.fps = 1000 / mean(gaps);
    this.stats.frame_ms = mean(costs);
    this.stats.frame_ms_p95 = costs[Math.floor((n - 1) * 0.95)];
    this.stats.gap_ms_p95 = gaps[Math.floor((n - 1) * 0.95)];
  }
}
