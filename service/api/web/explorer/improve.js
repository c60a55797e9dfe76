/** "Improve": a search for a geometry that does better, what it finds as it finds it, and the way back. */

import { ask, call, orNoAnswer } from "./api.js";
import { decimal, toNumber } from "./decimals.js";

const [HEIGHT, EDGE] = [90, 8];
const SVG = "http://www.w3.org/2000/svg";
const byId = (id) => document.getElementById(id);

export class Improve {
  #job = null; // the job of the search that runs
  #trace = []; // improvements: {census, value, met, geometry}
  #other = null; // {geometry, before}: what can be opened, and the way back
  #onAsk;
  #onShow;
  #onOpen;

  /**
   * `onAsk()` is to call `ask` and tell whether it was answered, `onShow(geometry)` draws a candidate, or none
   * for null, and `onOpen(geometry)` shows another geometry.
   */
  constructor({ onAsk, onShow, onOpen }) {
    [this.#onAsk, this.#onShow, this.#onOpen] = [onAsk, onShow, onOpen];
    byId("improve-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#search();
    });
    byId("objective").addEventListener("change", () => this.#chosen());
    byId("improve-stop").addEventListener("click", () => this.#stop());
    byId("open-best").addEventListener("click", () => this.#open());
    for (const id of ["low", "high"]) byId(id).addEventListener("input", () => (byId(id).dataset.edited = ""));
    new ResizeObserver(() => this.#paint()).observe(byId("improve-trace"));
    this.clear();
    this.#chosen();
  }

  /** Proposes the lengths about that of the slice, unless others were entered. */
  propose(l1) {
    for (const [id, share] of [["low", 0.9], ["high", 1.1]]) {
      const length = toNumber(l1) * share;
      if (Number.isFinite(length) && !("edited" in byId(id).dataset)) byId(id).value = decimal(length, 2);
    }
  }

  /** The question's members beside the geometry. */
  get members() {
    const objective = byId("objective").value;
    const range = { from: byId("low").value.trim(), to: byId("high").value.trim() };
    const cusps = this.#isCounting ? { min_cusps: 0 } : { max_cusps: Number(byId("most").value) };
    const budget = { censuses: Number(byId("censuses").value) };
    return { objective, requirement: { range, ...cusps }, vary: byId("vary").value, budget };
  }

  /** Forgets what was found, since the geometry has changed. */
  clear() {
    this.#trace = [];
    this.#other = null;
    byId("improve-now").textContent = "";
    byId("improvements").replaceChildren();
    byId("best").hidden = true;
    this.#paint();
    this.#onShow(null);
  }

  /** Asks for a design near a geometry, and tells of what is found as it is found. */
  async ask(geometry, signal, onProgress) {
    const told = {
      onProgress,
      onEvent: (name, data) => name === "improvement" && this.#hear(data),
      onJob: (job) => this.#begin(job),
    };
    const question = { geometry, ...this.members };
    const design = await ask("v1/designs", question, { signal, wait: 0, ...told }).catch((error) => {
      this.#refuse(error.message);
      return orNoAnswer(error);
    });
    if (design) this.#show(design);
  }

  #refuse(reason) {
    this.clear();
    byId("improve-now").textContent = reason;
  }

  #begin(job) {
    this.#job = job;
    byId("improve-stop").disabled = false;
  }

  /** Takes an improvement: once, even if the stream of events begins again. */
  #hear(improvement) {
    if (improvement.census <= (this.#trace.at(-1)?.census ?? 0)) return;
    this.#add(improvement);
    byId("improve-now").textContent = `Census ${improvement.census}: ${spoken(improvement)}.`;
    this.#onShow(improvement.geometry);
  }

  #show({ geometry, start, best, trace, censuses, stopped }) {
    this.clear();
    trace.forEach((improvement) => this.#add(improvement));
    const margin = best.margin?.proved ? ` Margin, proved: ±\u00a0${best.margin.proved}.` : "";
    const values = `${short(best.value)}, proved; the given geometry has ${short(start.value)}.`;
    const wish = `The wish is ${best.met ? "met" : "not met"}.`;
    byId("improve-now").textContent = `Best found of ${censuses} (${stopped}): ${values} ${wish}${margin}`;
    if (trace.length < 2) return;
    this.#onShow(best.geometry);
    this.#other = { geometry: best.geometry, before: geometry };
    this.#offer("", "Open the best found");
  }

  async #search() {
    if (byId("improve-start").disabled) return;
    this.clear();
    byId("improve-start").disabled = true;
    byId("improve-now").textContent = "Searching …";
    const isAnswered = await this.#onAsk();
    this.#job = null;
    byId("improve-start").disabled = false;
    byId("improve-stop").disabled = true;
    if (!isAnswered) this.clear();
  }

  /** Ends the search with the best found so far. */
  #stop() {
    byId("improve-stop").disabled = true;
    byId("improve-now").textContent = "Proving the best found so far …";
    call(this.#job.links.cancel ?? this.#job.links.self, { method: "DELETE" }).catch(() => {});
  }

  /** Whether the most cusps are sought, without a bound. */
  get #isCounting() {
    return byId("objective").value === "most-cusps";
  }

  #chosen() {
    byId("most").disabled = this.#isCounting;
  }

  #add(improvement) {
    this.#trace.push(improvement);
    const item = document.createElement("li");
    item.textContent = `census ${improvement.census}: ${spoken(improvement)}`;
    byId("improvements").prepend(item);
    this.#paint();
  }

  /** Draws the values over the censuses as steps, with discs that are hollow where the wish is not met. */
  #paint() {
    const svg = byId("improve-trace");
    svg.toggleAttribute("hidden", this.#trace.length === 0);
    const width = svg.clientWidth || 1;
    const values = this.#trace.map(({ value }) => Number(value));
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const last = Math.max(this.#trace.at(-1)?.census ?? 1, 2);
    const places = this.#trace.map(({ census }, k) => [
      EDGE + ((census - 1) / (last - 1)) * (width - 2 * EDGE),
      HEIGHT - EDGE - (high > low ? (values[k] - low) / (high - low) : 0.5) * (HEIGHT - 2 * EDGE),
    ]);
    const line = places.map(([x, y], k) => (k ? `H${x}V${y}` : `M${x} ${y}`)).join("");
    svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    const discs = places.map(([cx, cy], k) => shape("circle", { cx, cy, r: 4, class: this.#trace[k].met ? "met" : "" }));
    svg.replaceChildren(shape("path", { d: line || "M0 0" }), ...discs);
  }

  #offer(text, action) {
    byId("best-text").textContent = text;
    byId("open-best").textContent = action;
    byId("best").hidden = false;
  }

  /** Opens the best geometry found, and offers the way back. */
  #open() {
    const { geometry, before } = this.#other;
    this.#onOpen(geometry); // which clears
    if (!before) return;
    this.#other = { geometry: before };
    this.#offer("This is the best found.", "Go back");
  }
}

function spoken({ value, met }) {
  return `${short(value)}, wish ${met ? "" : "not "}met`;
}

function short(text) {
  return String(Number(Number(text).toPrecision(5))).replace("-", "−");
}

function shape(name, attributes) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}
