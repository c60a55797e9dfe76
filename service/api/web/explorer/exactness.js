/** "Tolerance": whether the number of cusps stays within a tolerance, and what binds it. */

import { counted } from "./census.js";
import { shortened } from "./decimals.js";
import { byId, make, on, write } from "./dom.js";
import { described } from "./geometry.js";
import { nearOf, nearText } from "./notices.js";
import { marginOf } from "./questions.js";

const TOLERANCES = ["00000", "0000", "000", "00", "0", ""].flatMap((zeros) => ["1", "2", "5"].map((digit) => `0.${zeros}${digit}`));

export class Exactness {
  #slider = byId("tolerance-slider");
  #ask;
  #example = null;

  /** `ask(name, questionOf, told)` asks about the state, `onOpen(geometry)` shows another geometry. */
  constructor({ ask, onOpen }) {
    this.#ask = ask;
    this.#slider.max = TOLERANCES.length - 1;
    this.#slider.value = TOLERANCES.indexOf("0.001");
    on(this.#slider, "input", () => this.#moved());
    on(this.#slider, "change", () => this.#decide());
    on("decide", "click", () => this.#decide());
    on("open-example", "click", () => onOpen(this.#example));
    this.clear();
    this.#moved();
  }

  get tolerance() {
    return TOLERANCES[Number(this.#slider.value)];
  }

  clear() {
    this.#example = null;
    write("verdict", "");
    byId("verdict").className = "count";
    write("first-order", "");
    byId("binding").replaceChildren();
    byId("counterexample").hidden = true;
  }

  async #decide() {
    const { tolerance } = this;
    const onRefusal = (reason) => {
      this.clear();
      write("verdict", reason);
    };
    const margin = await this.#ask("margin", (state) => marginOf(state, tolerance), { onRefusal });
    if (margin) this.#show(margin, tolerance);
  }

  #show(margin, tolerance) {
    this.clear();
    const { verdict, count, reason, asked, first_order: first, counterexample: example } = margin;
    const what = `${counted(count)} at L1 = ${asked.l1} for every geometry within ±\u00a0${tolerance}`;
    const open = reason ?? "neither a proof nor a counter-example was found";
    const said = { proved: `Proved: ${what}.`, refuted: `Refuted: not ${what}.`, open: `Open: ${open}.` };
    write("verdict", [nearText(nearOf(margin)), said[verdict]].filter(Boolean).join(" — "));
    byId("verdict").classList.add(verdict);
    if (first) {
      const radius = Number((Number(first.radius) * Number(tolerance)).toPrecision(3));
      write("first-order", `First order, an estimate: ±\u00a0${radius}. Limiting transitions:`);
      byId("binding").replaceChildren(...first.binding.map(moverOf));
    }
    if (!example) return;
    this.#example = example.geometry;
    write("counterexample-text", `${counted(example.count)} at L1 = ${example.l1} for ${described(example.geometry)}.`);
    byId("counterexample").hidden = false;
  }

  #moved() {
    write("tolerance-value", `±\u00a0${this.tolerance}`);
    this.#slider.ariaValueText = `plus or minus ${this.tolerance}`;
    this.clear();
  }
}

/** A transition, and the three lengths that move it most. */
function moverOf({ l1, kind, sensitivity }) {
  const slopes = Object.entries(sensitivity).map(([name, text]) => [name, Number(text)]);
  slopes.sort(([, a], [, b]) => Math.abs(b) - Math.abs(a));
  const most = slopes.slice(0, 3).map(([name, slope]) => `${name} ${slope < 0 ? "−" : "+"}${Math.abs(slope).toPrecision(3)}`);
  return make("li", { textContent: `${kind} at L1 = ${shortened(l1)}, which moves most with ${most.join(", ")}` });
}
