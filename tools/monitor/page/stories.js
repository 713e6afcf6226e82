// Sessions that come along: the list of them, each behind a link, and what is said of the one that is shown.

/** The name of the sample that the address asks for, or null. */
export function wantedSample() {
  return new URLSearchParams(location.search).get("sample");
}

/** The sample that is shown, or undefined. */
export function shownSample(hello) {
  return hello?.samples?.find((s) => s.name === hello.sample);
}

export class Stories {
  constructor(panel) {
    this.panel = panel;
    this.list = panel.querySelector("ul");
  }

  /** After each hello. */
  begin(hello) {
    this.list.replaceChildren(...(hello.samples ?? []).map((s) => entry(s, s.name === hello.sample)));
    this.panel.querySelector(".back").hidden = !hello.sample;
  }
}

function entry(sample, shown) {
  const item = document.createElement("li");
  const link = document.createElement("a");
  link.href = `?sample=${sample.name}`;
  link.textContent = sample.title;
  if (shown) link.setAttribute("aria-current", "page");
  const live = document.createElement("code");
  live.textContent = sample.live;
  item.append(link, ` ${sample.about} Live: `, live);
  return item;
}
