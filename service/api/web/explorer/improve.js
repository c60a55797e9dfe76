/** "Design": a search for a geometry that does better, and what it finds as it finds it. */

import { ask, call, orNoAnswer } from "./api.js";
import { decimal, shortened, toNumber } from "./decimals.js";
import { byId, make, on, write } from "./dom.js";

export class Improve {
  #job = null; // the job of the search that runs
  #last = 0; // the census of the last improvement
  #best = null; // the geometry that can be opened
  #run;
  #onShow;

  /**
   * `run(task)` runs `task(geometry, {signal, onProgress})`, `onShow(geometry)` draws a candidate, or none
   * for null, and `onOpen(geometry)` shows another geometry.
   */
  constructor({ run, onShow, onOpen }) {
    [this.#run, this.#onShow] = [run, onShow];
    on("improve-form", "submit", (event) => {
      event.preventDefault();
      this.#search();
    });
    on("objective", "change", () => this.#chosen());
    on("improve-stop", "click", () => this.#stop());
    on("open-best", "click", () => onOpen(this.#best));
    for (const id of ["low", "high"]) on(id, "input", () => (byId(id).dataset.edited = ""));
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

  get members() {
    const objective = byId("objective").value;
    const range = { from: byId("low").value.trim(), to: byId("high").value.trim() };
    const cusps = this.#isCounting ? { min_cusps: 0 } : { max_cusps: Number(byId("most").value) };
    const budget = { censuses: Number(byId("censuses").value) };
    return { objective, requirement: { range, ...cusps }, vary: byId("vary").value, budget };
  }

  clear() {
    this.#last = 0;
    write("improve-now", "");
    byId("improvements").replaceChildren();
    byId("open-best").hidden = true;
    this.#onShow(null);
  }

  async #ask(geometry, follow) {
    const told = { ...follow, onEvent: (name, data) => name === "improvement" && this.#hear(data), onJob: (job) => this.#begin(job) };
    const question = { geometry, ...this.members };
    const design = await ask("v1/designs", question, { wait: 0, ...told }).catch((error) => {
      const none = orNoAnswer(error);
      write("improve-now", error.message);
      return none;
    });
    if (design) this.#show(design);
    return true;
  }

  #begin(job) {
    this.#job = job;
    byId("improve-stop").disabled = false;
  }

  /** Takes an improvement: once, even if the stream of events begins again. */
  #hear(improvement) {
    if (improvement.census <= this.#last) return;
    this.#add(improvement);
    write("improve-now", `Census ${improvement.census}: ${this.#spoken(improvement)}.`);
    this.#onShow(improvement.geometry);
  }

  #show({ start, best, trace, censuses, stopped }) {
    this.clear();
    trace.forEach((improvement) => this.#add(improvement));
    const margin = best.margin?.proved ? ` Margin, proved: ±\u00a0${best.margin.proved}.` : "";
    const values = `${this.#spoken(best)}; the given geometry has ${shortened(start.value, 5)}`;
    write("improve-now", `Best found of ${censuses} (${stopped}), proved: ${values}.${margin}`);
    if (trace.length < 2) return;
    this.#onShow(best.geometry);
    this.#best = best.geometry;
    byId("open-best").hidden = false;
  }

  async #search() {
    if (byId("improve-start").disabled) return;
    this.clear();
    byId("improve-start").disabled = true;
    write("improve-now", "Searching …");
    const isAnswered = await this.#run((...task) => this.#ask(...task));
    this.#job = null;
    byId("improve-start").disabled = false;
    byId("improve-stop").disabled = true;
    if (!isAnswered) this.clear();
  }

  #stop() {
    byId("improve-stop").disabled = true;
    write("improve-now", "Proving the best found so far …");
    call(this.#job.links.self, { method: "DELETE" }).catch(() => {});
  }

  get #isCounting() {
    return byId("objective").value === "most-cusps";
  }

  #chosen() {
    byId("most").disabled = this.#isCounting;
  }

  #add(improvement) {
    this.#last = improvement.census;
    byId("improvements").prepend(make("li", { textContent: `census ${improvement.census}: ${this.#spoken(improvement)}` }));
  }

  /** The length of a range is not met or missed. */
  #spoken({ value, met }) {
    const wish = byId("objective").value === "longest-range" ? "" : `, wish ${met ? "" : "not "}met`;
    return `${shortened(value, 5)}${wish}`;
  }
}
