// Dark and light: what the system prefers, or what the switch says. Canvases take their colours from the style sheet too.

const NAMES = ["outside", "floor", "grid", "wall", "nobody", "outline", "held", "own", "alarm", "difference", "predicted", "confirmed", "text", "quiet"];
const CHOICES = ["auto", "light", "dark"];
const dark = matchMedia("(prefers-color-scheme: dark)");

export class Theme {
  constructor(button) {
    this.button = button;
    this.choice = remembered();
    this.changed = () => {};
    button.addEventListener("click", () => {
      this.choice = CHOICES[(CHOICES.indexOf(this.choice) + 1) % CHOICES.length];
      remember(this.choice);
      this.apply();
    });
    dark.addEventListener("change", () => this.apply());
    this.apply();
  }

  apply() {
    const name = this.choice === "auto" ? (dark.matches ? "dark" : "light") : this.choice;
    document.documentElement.dataset.theme = name;
    this.button.firstElementChild.textContent = { auto: "◐", light: "☀", dark: "☾" }[this.choice];
    this.button.lastElementChild.textContent = this.choice;
    this.button.setAttribute("aria-label", `Colours: ${this.choice}. Switch`);
    const style = getComputedStyle(document.documentElement);
    this.colours = Object.fromEntries(NAMES.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
    this.changed();
  }
}

// Storage may be forbidden; then the switch holds as long as the page.
function remembered() {
  try {
    const choice = localStorage.getItem("padr-theme");
    return CHOICES.includes(choice) ? choice : "auto";
  } catch {
    return "auto";
  }
}

function remember(choice) {
  try {
    localStorage.setItem("padr-theme", choice);
  } catch {
    // Nothing to do.
  }
}
