// Looks over the page for what people who see little, or who use no mouse, would stumble on; returns the findings as texts.
// What a browser itself computes (names of controls) and what keys reach is for reach.py. WCAG 2.2: https://www.w3.org/TR/WCAG22/
const CONTROLS = "button, a[href], input, select, textarea, summary, [tabindex], [contenteditable]";
const LANDMARKS = "header, main, footer, nav, aside, section[aria-label], section[aria-labelledby], [role=alert]";

const shown = (e) => e.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true }) && !e.closest(".unseen");
const called = (e) => `${e.tagName.toLowerCase()}${e.id ? `#${e.id}` : ""}${e.className && typeof e.className === "string" ? `.${e.className.trim().replaceAll(" ", ".")}` : ""} “${e.textContent.trim().slice(0, 40)}”`;

// --- structure

function structure() {
  const findings = [];
  if (!document.documentElement.lang) findings.push("the page has no language");
  if (!document.title) findings.push("the page has no title");
  const levels = [...document.querySelectorAll("h1, h2, h3, h4, h5, h6")].filter(shown).map((h) => Number(h.tagName[1]));
  if (levels.filter((l) => l === 1).length !== 1) findings.push(`${levels.filter((l) => l === 1).length} headings of the first level, not one`);
  levels.forEach((l, i) => { if (i > 0 && l > levels[i - 1] + 1) findings.push(`a heading of level ${l} after one of level ${levels[i - 1]}`); });
  for (const one of ["main", "header"]) {
    if (document.querySelectorAll(one).length !== 1) findings.push(`not one ${one}`);
  }
  for (const e of document.querySelectorAll("[tabindex]")) {
    if (e.tabIndex > 0) findings.push(`tabindex ${e.tabIndex}: ${called(e)}`);
  }
  for (const e of document.querySelectorAll("img, svg, canvas, [role=img]")) {
    if (shown(e) && !e.getAttribute("alt") && !e.getAttribute("aria-label") && !e.closest("[aria-hidden=true], .chart")) findings.push(`no alternative text: ${called(e)}`);
  }
  const ids = [...document.querySelectorAll("[id]")].map((e) => e.id);
  for (const id of new Set(ids.filter((v, i) => ids.indexOf(v) !== i))) findings.push(`two elements have the id ${id}`);
  return findings;
}

// --- contrast: at least 4.5 : 1, and 3 : 1 for large text (1.4.3)

function parsed(colour) {
  const [r, g, b, a = 1] = colour.match(/[\d.]+/g).map(Number);
  return { r, g, b, a };
}

function over(top, below) {
  const mix = (c) => top[c] * top.a + below[c] * (1 - top.a);
  return { r: mix("r"), g: mix("g"), b: mix("b"), a: 1 };
}

/** The colour behind an element: its background over those of its ancestors. */
function behind(element) {
  const layers = [];
  for (let e = element; e; e = e.parentElement) {
    const colour = parsed(getComputedStyle(e).backgroundColor);
    if (colour.a > 0) layers.push(colour);
    if (colour.a === 1) break;
  }
  return layers.reverse().reduce((below, layer) => over(layer, below), { r: 255, g: 255, b: 255, a: 1 });
}

function luminance({ r, g, b }) {
  const linear = (c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
}

function contrasts() {
  const findings = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const seen = new Set();
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const e = node.parentElement;
    if (!node.data.trim() || seen.has(e) || !shown(e) || e.closest(":disabled, select, option, .key, script")) continue;
    seen.add(e);
    findings.push(...contrast(e, e));
  }
  for (const e of document.querySelectorAll("select, input:not([type=range], [type=checkbox])")) {
    if (shown(e) && !e.matches(":disabled")) findings.push(...contrast(e, e));
  }
  return findings;
}

function contrast(e) {
  const style = getComputedStyle(e);
  let opacity = 1;
  for (let a = e; a; a = a.parentElement) opacity *= Number(getComputedStyle(a).opacity);
  const back = behind(e);
  const front = over({ ...parsed(style.color), a: parsed(style.color).a * opacity }, back);
  const [light, dark] = [luminance(front), luminance(back)].sort((a, b) => b - a);
  const ratio = (light + 0.05) / (dark + 0.05);
  const size = parseFloat(style.fontSize);
  const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
  return ratio < (large ? 3 : 4.5) ? [`contrast ${ratio.toFixed(2)}: ${called(e)}`] : [];
}

// --- what stands outside of every landmark is not found by who goes from one to the next

function outside() {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const findings = [];
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const e = node.parentElement;
    if (node.data.trim() && shown(e) && !e.closest(LANDMARKS) && !e.matches("script")) findings.push(`in no landmark: ${called(e)}`);
  }
  return findings;
}

/** Marks the controls that Tab should come to, in the order of the document, and says what they are called. */
export function controls() {
  const all = [...document.querySelectorAll(CONTROLS)].filter((e) => shown(e) && !e.matches(":disabled, [tabindex='-1']"));
  all.forEach((e, i) => { e.dataset.control = i; });
  return all.map(called);
}

/** Which control has the focus, and whether that can be seen; -1 for none. */
export function focused() {
  const e = document.activeElement;
  const style = getComputedStyle(e);
  return { control: Number(e.dataset.control ?? -1), seen: style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2 };
}

export function findings() {
  return [...structure(), ...outside(), ...contrasts()];
}
