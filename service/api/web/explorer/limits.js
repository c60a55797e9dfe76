/** Joint limits: a rectangle that is drawn or entered, and what it means for the assembly mode. */

import { counted } from "./census.js";
import { pointed, shortened, toNumber } from "./decimals.js";
import { byId, on, write } from "./dom.js";
import { mark } from "./form.js";
import { nearOf, nearText } from "./notices.js";
import { reveal } from "./panel.js";
import { modesOf } from "./questions.js";
import { limitsOf } from "./state.js";

const ENDS = ["l2-min", "l2-max", "l3-min", "l3-max", "l1-min", "l1-max"];
const THRESHOLDS = ["clearance", "tolerance"];

export class JointLimits {
  #told;

  /**
   * `onChange(limits)` is told the limits or null, `onDraw(isDrawing)` whether a drag draws them, `onPath(path)` which path
   * proves that the mode can change; `ask` asks about the state.
   */
  constructor(told) {
    this.#told = told;
    for (const id of ENDS) on(id, "input", () => this.#entered());
    on("draw-limits", "click", () => this.draws(byId("draw-limits").ariaPressed !== "true"));
    on("clear-limits", "click", () => told.onChange(null));
    on("ask-modes", "click", () => this.#decide());
    for (const name of THRESHOLDS) on(`modes-${name}`, "input", () => this.clear());
  }

  draws(isDrawing) {
    byId("draw-limits").ariaPressed = isDrawing;
    this.#told.onDraw(isDrawing);
    if (isDrawing) reveal("slice");
  }

  async #decide() {
    this.clear();
    if (byId("l1-max").value && !byId("l1-min").value) return this.#tell("A range of L1 begins at a length > 0: enter L1 from, too.");
    const thresholds = Object.fromEntries(THRESHOLDS.map((name) => [name, pointed(byId(`modes-${name}`).value)]).filter(([, text]) => text));
    const told = { onRefusal: (reason) => this.#tell(reason), hasFields: true };
    const modes = await this.#told.ask("assembly modes", (state) => modesOf(state, thresholds), told);
    if (!modes) return;
    if (modes.witness) this.#told.onPath(modes.witness.path);
    this.#tell(modes);
  }

  /** Takes the verdict away. */
  clear() {
    write("modes-verdict", "");
  }

  #entered() {
    const texts = ENDS.map((id) => pointed(byId(id).value));
    const wrong = ENDS.filter((id, k) => texts[k] && !(toNumber(texts[k]) >= 0));
    const crossed = [1, 3, 5].filter((k) => toNumber(texts[k - 1]) > toNumber(texts[k])).map((k) => ENDS[k]);
    for (const [k, id] of ENDS.entries()) {
      const fault = crossed.includes(id) ? `${texts[k]} is less than ${texts[k - 1]}` : "";
      mark(id, wrong.includes(id) ? `${texts[k]} is no length` : fault);
    }
    if (wrong.length + crossed.length === 0) this.#told.onChange(limitsOf(texts.join(",")));
  }

  show(limits, cusps) {
    for (const id of ENDS) {
      const [leg, end] = id.split("-");
      const text = limits?.[leg]?.[end] ?? "";
      if (pointed(byId(id).value) === text || byId(id) === document.activeElement) continue;
      byId(id).value = text;
      mark(id, "");
    }
    const isLimited = limits?.l2 || limits?.l3;
    write("limits-count", isLimited && cusps ? `${counted(cusps.filter((cusp) => isWithin(cusp, limits)).length)} within the limits, of ${cusps.length}` : "");
  }

  /** Shows what a document about assembly modes says, or a reason that there is none. */
  #tell(modes) {
    const { change, witness, reason, asked = {}, best_clearance: best } = modes;
    const proved = witness?.path.clearance?.proved;
    const kept = [
      ...(asked.limits || asked.range ? [" within the limits"] : []),
      ...(asked.clearance ? [` at least ${asked.clearance}° from singular poses`] : []),
      ...(asked.tolerance ? [` for every geometry within ±\u00a0${[...new Set(Object.values(asked.tolerance))].join(", ")}`] : []),
    ].join(",");
    const said = {
      possible: () => `Yes: from pose ${witness.from} to pose ${witness.to} of L1 = ${witness.l1}, L2 = ${witness.l2}, L3 = ${witness.l3}, by a path without a singularity${kept}, which is drawn and which Play shows${proved ? `; it keeps ${shortened(proved, 4)}° from singular poses` : ""}. This is proved.`,
      impossible: () => `No: without a singularity no pose can become another one of the same lengths${kept}. This is proved.`,
      undecided: () => `Undecided: ${reason}${best ? `; the widest path that was found keeps ${shortened(best, 4)}° from singular poses` : ""}.`,
    };
    write("modes-verdict", modes ? [nearText(nearOf(modes)), said[change]?.() ?? modes].filter(Boolean).join(" — ") : "");
  }
}

/** Whether the limits of legs 2 and 3 let a cusp be. */
export function isWithin(cusp, limits) {
  return ["l2", "l3"].every((leg) => {
    const { min = "0", max } = limits[leg] ?? {};
    return Number(cusp[leg]) >= toNumber(min) && (max === undefined || Number(cusp[leg]) <= toNumber(max));
  });
}
