/** "How exactly?": whether the number of cusps stays within a tolerance, what binds it, and a counter-example. */

import { counted } from "./census.js";
import { LENGTHS } from "./geometry.js";

const TOLERANCES = [-6, -5, -4, -3, -2, -1].flatMap((power) => ["1", "2", "5"].map((digit) => decimal(digit, power)));
const byId = (id) => document.getElementById(id);

export class Exactness {
  #slider = byId("tolerance-slider");
  #onAsk;
  #onOpen;
  #example = null;

  /** `onAsk(tolerance)` asks for a verdict, `onOpen(geometry)` shows another geometry. */
  constructor({ onAsk, onOpen }) {
    [this.#onAsk, this.#onOpen] = [onAsk, onOpen];
    this.#slider.max = TOLERANCES.length - 1;
    this.#slider.value = TOLERANCES.indexOf("0.001");
    this.#slider.addEventListener("input", () => this.#moved());
    this.#slider.addEventListener("change", () => this.#onAsk(this.tolerance));
    byId("decide").addEventListener("click", () => this.#onAsk(this.tolerance));
    byId("open-example").addEventListener("click", () => this.#open());
    this.clear();
    this.#moved();
  }

  get tolerance() {
    return TOLERANCES[Number(this.#slider.value)];
  }

  /** Forgets the verdict, since what it is about has changed. */
  clear() {
    this.#example = null;
    byId("verdict").textContent = "";
    byId("verdict").className = "count";
    byId("first-order").textContent = "";
    byId("binding").replaceChildren();
    byId("counterexample").hidden = true;
  }

  /** Says that there is no verdict, and why. */
  refuse(reason) {
    this.clear();
    byId("verdict").textContent = reason;
  }

  /** Shows a margin, the answer for a tolerance. */
  show(margin, l1, tolerance) {
    this.clear();
    const { verdict, count, reason, first_order: first, counterexample: example } = margin;
    const what = `${counted(count)} at L1 = ${l1} for every geometry within ±\u00a0${tolerance}`;
    const open = reason ?? "neither a proof nor a counter-example was found";
    const said = { proved: `Proved: ${what}.`, refuted: `Refuted: not ${what}.`, open: `Open: ${open}.` };
    byId("verdict").textContent = said[verdict];
    byId("verdict").classList.add(verdict);
    if (first) {
      const radius = Number((Number(first.radius) * Number(tolerance)).toPrecision(3));
      byId("first-order").textContent = `First order, an estimate: ±\u00a0${radius}. What binds it:`;
      byId("binding").replaceChildren(...first.binding.map(moverOf));
    }
    if (!example) return;
    this.#example = { geometry: example.geometry, before: margin.geometry };
    const lengths = LENGTHS.map((name) => `${name}\u00a0=\u00a0${example.geometry[name].replace("-", "−")}`).join(", ");
    this.#offer(`${counted(example.count)} at L1 = ${example.l1} for ${lengths}.`, "Open the counter-example");
  }

  #moved() {
    byId("tolerance-value").textContent = `±\u00a0${this.tolerance}`;
    this.#slider.setAttribute("aria-valuetext", `plus or minus ${this.tolerance}`);
    this.clear();
  }

  #offer(text, action) {
    byId("counterexample-text").textContent = text;
    byId("open-example").textContent = action;
    byId("counterexample").hidden = false;
  }

  /** Opens the counter-example, and offers the way back. */
  #open() {
    const { geometry, before } = this.#example;
    this.#onOpen(geometry); // which clears
    if (!before) return;
    this.#example = { geometry: before };
    this.#offer("This is the counter-example.", "Go back");
  }
}

/** A transition, and the three lengths that move it most. */
function moverOf({ l1, kind, sensitivity }) {
  const item = document.createElement("li");
  const slopes = Object.entries(sensitivity).map(([name, text]) => [name, Number(text)]);
  slopes.sort(([, a], [, b]) => Math.abs(b) - Math.abs(a));
  const most = slopes.slice(0, 3).map(([name, slope]) => `${name} ${slope < 0 ? "−" : "+"}${Math.abs(slope).toPrecision(3)}`);
  item.textContent = `${kind} at L1 = ${Number(Number(l1).toPrecision(6))}, which moves most with ${most.join(", ")}`;
  return item;
}

/** A digit times a power of ten, exact. */
function decimal(digit, power) {
  return `0.${"0".repeat(-power - 1)}${digit}`;
}
