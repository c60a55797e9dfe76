/** The census: the number of cusps over L1, narrow windows widened, under a slider for L1. */

import { byId, make, on, shape, write } from "./dom.js";
import { between, shortened, toNumber } from "./decimals.js";
import { LENGTHS, measured } from "./geometry.js";

const STEPS = 1000;
const APART = 3; // steps of the slider between frames that are asked for ahead
const LEAST = 0.02; // the least share of the strip that a window gets
const [FOOT, HEAD] = [16, 16];
const EDGE = 8; // pixels: half a thumb of the slider, so that the strip lies over its places

export class CensusStrip {
  #svg = byId("census-strip");
  #slider = byId("l1-slider");
  #census = null;
  #windows = []; // {from, to, count, left, right}: lengths, and shares of the strip
  #width = 1;
  #height = 1;
  #l1 = "1";
  #place = 0; // of the slider
  #onChange;

  /** `onChange(l1, by)` is told each length that is chosen, so many steps away, `onReach()` that one may soon be. */
  constructor({ onChange, onReach }) {
    this.#onChange = onChange;
    this.#slider.max = STEPS;
    on(this.#slider, "input", () => this.#choose(this.#at(Number(this.#slider.value) / STEPS)));
    on(this.#slider, "keydown", (event) => this.#key(event));
    on(this.#slider, "focus", onReach);
    on(this.#svg, "pointerenter", onReach);
    for (const button of document.querySelectorAll("button[data-window]")) on(button, "click", () => this.#step(Number(button.dataset.window)));
    for (const type of ["pointerdown", "pointermove"]) on(this.#svg, type, (event) => this.#point(event));
    new ResizeObserver(() => this.#paint()).observe(this.#svg);
  }

  #point(event) {
    if (event.type === "pointerdown" && this.#windows.length > 0) this.#svg.setPointerCapture(event.pointerId);
    if (!event.buttons || this.#windows.length === 0) return;
    const step = Math.round((STEPS * (event.offsetX - EDGE)) / this.#width);
    this.#choose(this.#at(Math.min(Math.max(step, 1), STEPS) / STEPS));
  }

  draw(census) {
    this.#census = census;
    this.#windows = census ? windowsOf(census, toNumber(this.#l1)) : [];
    this.#slider.disabled = !census;
    fillTable(census);
    fillDegenerate(census);
    this.#paint();
  }

  #paint() {
    this.#width = Math.max(this.#svg.clientWidth - 2 * EDGE, 1);
    this.#height = Math.max(this.#svg.clientHeight, FOOT + HEAD);
    this.#svg.setAttribute("viewBox", `${-EDGE} 0 ${this.#width + 2 * EDGE} ${this.#height}`);
    this.#svg.replaceChildren(...picture(this.#windows, this.#width, this.#height));
    this.#mark(this.#l1);
  }

  show(l1) {
    if (l1 !== this.#l1) this.#mark(l1);
  }

  #mark(l1) {
    this.#l1 = l1;
    const length = toNumber(l1);
    if (length > this.#windows.at(-1)?.end) { // beyond what the slider reaches: it reaches further
      this.#windows = windowsOf(this.#census, length);
      this.#paint();
      return;
    }
    const share = this.#shareOf(length);
    if (share === null) return;
    this.#slider.value = this.#place = Math.round(share * STEPS);
    const window = this.#windows[this.#indexOf(toNumber(l1))];
    const ends = window.to === Infinity ? `above ${window.text.from}` : `${window.text.from} to ${window.text.to}`;
    this.#slider.ariaValueText = `L1 = ${l1}, ${counted(window.count)}, window ${ends}`;
    write("window", `${counted(window.count)} in the window ${ends}`);
    this.#svg.querySelector(".here")?.remove();
    this.#svg.append(shape("path", { class: "here", d: `M${share * this.#width} ${HEAD - 4}V${this.#height - FOOT}` }));
  }

  #key(event) {
    const actions = {
      PageUp: () => this.#cross(1),
      PageDown: () => this.#cross(-1),
      "]": () => this.#step(1),
      "[": () => this.#step(-1),
    };
    if (!(event.key in actions) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  #step(by) {
    const window = this.#neighbour(by);
    if (window) this.#choose(between(window.from, window.end));
  }

  #cross(by) {
    const window = this.#neighbour(by);
    if (window) this.#choose(this.#at(by > 0 ? window.left + 1 / STEPS : window.right - 1 / STEPS));
  }

  #neighbour(by) {
    return this.#windows[this.#indexOf(toNumber(this.#l1)) + by];
  }

  #choose(l1) {
    if (l1 === null) return;
    const before = this.#place;
    this.show(l1);
    this.#onChange(l1, this.#place - before);
  }

  /** The length so many frames away, if the slider reaches there: each `APART` of its steps is one. */
  ahead(frames) {
    const step = APART * (Math.round(this.#place / APART) + frames);
    return this.#windows.length > 0 && step > 0 && step <= STEPS ? this.#at(step / STEPS) : null;
  }

  #at(share) {
    const window = this.#windows.find(({ right }) => share <= right) ?? this.#windows.at(-1);
    const length = (s) => window.from + ((s - window.left) / (window.right - window.left)) * (window.end - window.from);
    const half = 0.5 / STEPS;
    const low = length(Math.max(share - half, window.left));
    return between(low, length(Math.min(share + half, window.right)));
  }

  #indexOf(length) {
    const index = this.#windows.findIndex(({ to }) => length < to);
    return index < 0 ? this.#windows.length - 1 : index;
  }

  #shareOf(length) {
    const window = this.#windows[this.#indexOf(length)];
    if (!window || !Number.isFinite(length)) return null;
    const inside = (length - window.from) / (window.end - window.from);
    return window.left + Math.min(Math.max(inside, 0), 1) * (window.right - window.left);
  }
}

/**
 * The windows with their shares of the strip, none too narrow to be hit. The last one reaches beyond all that may
 * matter: transitions, ends of what is degenerate, sides of the triangles, the slice.
 */
function windowsOf({ intervals, degenerate = [], transitions, geometry }, l1) {
  const ends = degenerate.flatMap(({ from, to }) => [from, to ?? 0]);
  const lengths = measured(geometry);
  const sides = LENGTHS.map((name) => Math.abs(lengths[name]));
  const known = [intervals.at(-1).from, ...ends].map(toNumber);
  const reach = 1.15 * Math.max(...known, ...sides, l1 || 0);
  const windows = intervals.map(({ from, to, count }) => {
    const [start, stop] = [toNumber(from), to === null ? Infinity : toNumber(to)];
    const end = Math.min(stop, Math.max(reach, start * 1.15));
    const text = { from: shortened(from, 9), to: to === null ? "∞" : shortened(to, 9) };
    const kind = transitions.find(({ l1: length }) => length === from)?.kind ?? "";
    return { kind, from: start, to: stop, end, count, text, share: Math.max((end - start) / reach, LEAST) };
  });
  const whole = windows.reduce((sum, { share }) => sum + share, 0);
  let right = 0;
  for (const window of windows) {
    window.isWidened = window.share === LEAST;
    window.left = right;
    right += window.share / whole;
    window.right = right;
  }
  return windows;
}

function picture(windows, width, tall) {
  const most = Math.max(...windows.map(({ count }) => count), 1);
  const height = (count) => ((tall - FOOT - HEAD) * count) / most;
  const parts = [hatching()];
  let labelled = -Infinity;
  for (const { left, right, count, text, kind, isWidened } of windows) {
    const [x, wide, y] = [left * width, (right - left) * width, tall - FOOT - height(count)];
    const what = `${counted(count)} for L1 ${text.to === "∞" ? `above ${text.from}` : `from ${text.from} to ${text.to}`}`;
    parts.push(shape("rect", { class: "bar", x, y, width: wide, height: height(count) }));
    if (isWidened) parts.push(shape("rect", { fill: "url(#hatching)", x, y, width: wide, height: height(count) }));
    parts.push(shape("path", { class: "step", d: `M${x} ${y}h${wide}` }));
    parts.push(shape("rect", { fill: "transparent", x, y: 0, width: wide, height: tall, "data-what": what }));
    if (kind) {
      const mark = { class: "mark", d: `M${x} ${HEAD - 4}V${tall - FOOT + 3}` };
      parts.push(shape("path", mark), shape("rect", { fill: "transparent", x: x - 2, y: 0, width: 4, height: tall, "data-what": `Transition, ${kind}, at L1 = ${text.from}` }));
    }
    if (x - labelled < 52 || x > width - 60) continue;
    parts.push(shape("text", { class: "length", x, y: tall - 3 }, shortened(text.from, 5)));
    labelled = x;
  }
  if (windows.length > 0) parts.push(shape("text", { class: "length", x: width - 8, y: tall - 3 }, shortened(windows.at(-1).end, 3)));
  return [...parts, ...numbers(windows, width, (count) => tall - FOOT - height(count) - 4)];
}

function numbers(windows, width, heightOf) {
  const taken = [];
  return [...windows].sort((one, other) => other.count - one.count).flatMap(({ left, right, count }) => {
    const [x, y, half] = [((left + right) / 2) * width, heightOf(count), 4.8 * String(count).length];
    if (taken.some((other) => Math.abs(other.x - x) < other.half + half && Math.abs(other.y - y) < 11)) return [];
    taken.push({ x, y, half });
    return [shape("text", { class: "number", x, y }, count)];
  });
}

function hatching() {
  const pattern = shape("pattern", { id: "hatching", width: 5, height: 5, patternUnits: "userSpaceOnUse" });
  pattern.append(shape("path", { class: "hatch", d: "M0 5L5 0" }));
  return pattern;
}

function fillTable(census) {
  const rows = (census?.intervals ?? []).map(({ from, to, count }, k) => {
    const row = make("tr");
    const kind = census.transitions.find(({ l1 }) => l1 === to)?.kind ?? "";
    for (const text of [shortened(from, 12), to === null ? "∞" : shortened(to, 12), count, kind]) row.insertCell().textContent = text;
    return row;
  });
  byId("census-rows").replaceChildren(...rows);
}

/** What is degenerate in every slice of a range, which no transition tells. */
function fillDegenerate(census) {
  const lines = (census?.degenerate ?? []).map((part) => make("li", { textContent: `Degenerate: ${degenerateText(part)}` }));
  const list = byId("census-degenerate");
  list.replaceChildren(...lines);
  list.hidden = lines.length === 0;
}

function degenerateText({ kind, from, to, count, equation }) {
  const range = from === "0" && to === null ? "" : ` for L1 from ${shortened(from)}${to === null ? "" : ` to ${shortened(to)}`}`;
  const where = from === to ? `at L1 = ${shortened(from)}` : `in every slice${range}`;
  if (kind !== "curve") return `${count} pose${count === 1 ? "" : "s"} of kind ${kind} ${where}`;
  return `a curve of degenerate poses ${where}${equation === undefined ? "" : `: ${equation}`}`;
}

export function counted(number) {
  return `${number} cusp${number === 1 ? "" : "s"}`;
}
