// The time line of a recording: slider, play, steps and speed. The program keeps the position, for all browsers.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 10];

export class Replay {
  constructor(panel, connection, session) {
    this.panel = panel;
    this.session = session;
    this.connection = connection;
    this.slider = panel.querySelector("input");
    this.play = panel.querySelector(".play");
    this.where = panel.querySelector("output");
    this.speed = panel.querySelector("select");
    this.failed = () => {};
    this.shared = () => ""; // the address of what is seen now
    panel.querySelector(".share").addEventListener("click", () => this.share());
    for (const s of SPEEDS) this.speed.append(new Option(`${s} ×`, s));
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.play.addEventListener("click", () => this.ask({ type: this.session.timeline?.playing ? "halt" : "play" }));
    this.speed.addEventListener("change", () => this.ask({ type: "speed", speed: Number(this.speed.value) }));
    for (const b of panel.querySelectorAll("[data-step]")) {
      b.addEventListener("click", () => this.ask({ type: "step", ticks: Number(b.dataset.step) }));
    }
  }

  /** Puts the link into the address bar, and where the browser allows it into the clipboard. */
  async share() {
    const link = this.shared();
    history.replaceState(null, "", link);
    let said = "The link is copied.";
    try {
      await navigator.clipboard.writeText(link);
    } catch {
      said = "The link is in the address bar.";
    }
    const status = this.panel.querySelector(".status");
    status.textContent = said;
    setTimeout(() => { status.textContent = ""; }, 6000);
  }

  async ask(message) {
    const answer = await this.connection.ask(message);
    this.failed(answer.ok ? "" : answer.text);
  }

  /** Asks for a tick; while one question is under way only the newest wish is kept. */
  async seek(tick) {
    this.wanted = tick;
    if (this.seeking) return;
    this.seeking = true;
    while (this.wanted !== null) {
      const to = this.wanted;
      this.wanted = null;
      await this.ask({ type: "seek", tick: to });
    }
    this.seeking = false;
  }

  update() {
    const { timeline } = this.session;
    this.panel.hidden = !this.session.replayed();
    if (this.panel.hidden || !timeline) return;
    this.slider.min = timeline.first;
    this.slider.max = timeline.last;
    if (!this.seeking) this.slider.value = timeline.tick;
    this.play.textContent = timeline.playing ? "❚❚ Pause" : "▶ Play";
    this.where.textContent = `tick ${timeline.tick}, ${(timeline.tick / 60).toFixed(2)} s of ${(timeline.last / 60).toFixed(1)} s`;
    this.slider.setAttribute("aria-valuetext", this.where.textContent);
    if (document.activeElement !== this.speed) this.speed.value = nearest(timeline.speed);
    this.panel.querySelector(".sample").textContent = timeline.sample > 1 ? `every ${timeline.sample}th tick is kept` : "";
  }
}

function nearest(speed) {
  return String(SPEEDS.reduce((a, b) => (Math.abs(b - speed) < Math.abs(a - speed) ? b : a)));
}
