/** Joint limits: a rectangle that is drawn or entered, and what it means for the assembly mode. */

import { counted } from "./census.js";
import { pointed, toNumber } from "./decimals.js";
import { byId, on, write } from "./dom.js";
import { mark } from "./form.js";
import { nearOf, nearText } from "./notices.js";
import { reveal } from "./panel.js";
import { modesOf } from "./questions.js";
import { limitsOf } from "./state.js";

const ENDS = ["l2-min", "l2-max", "l3-min", "l3-max"];

export class JointLimits {
  #told;

  /** `onChange(limits)` is told the limits or null, `onDraw(isDrawing)` whether a drag draws them; `ask` asks about the state. */
  constructor(told) {
    this.#told = told;
    for (const id of ENDS) on(id, "input", () => this.#entered());
    on("draw-limits", "click", () => this.draws(byId("draw-limits").ariaPressed !== "true"));
    on("clear-limits", "click", () => told.onChange(null));
    on("ask-modes", "click", async () => {
      const modes = await told.ask("assembly modes", modesOf, { onRefusal: (reason) => this.#tell(reason) });
      if (modes) this.#tell(modes);
    });
  }

  draws(isDrawing) {
    byId("draw-limits").ariaPressed = isDrawing;
    this.#told.onDraw(isDrawing);
    if (isDrawing) reveal("slice");
  }

  #entered() {
    const texts = ENDS.map((id) => pointed(byId(id).value));
    const wrong = ENDS.filter((id, k) => texts[k] && !(toNumber(texts[k]) >= 0));
    const crossed = [1, 3].filter((k) => toNumber(texts[k - 1]) > toNumber(texts[k])).map((k) => ENDS[k]);
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
    write("limits-count", limits && cusps ? `${counted(cusps.filter((cusp) => isWithin(cusp, limits)).length)} within the limits, of ${cusps.length}` : "");
    this.#tell("");
  }

  /** Shows what a document about assembly modes says, or a reason that there is none. */
  #tell(modes) {
    const { change, witness, reason } = modes;
    const said = {
      possible: () => `Yes: from pose ${witness.from} to pose ${witness.to} at L2 = ${witness.l2}, L3 = ${witness.l3}, by a path without a singularity. This is proved.`,
      impossible: () => "No: without a singularity, the machine cannot reach another pose with the same lengths. This is proved.",
      undecided: () => `Undecided: ${reason}.`,
    };
    write("modes-verdict", modes ? [nearText(nearOf(modes)), said[change]?.() ?? modes].filter(Boolean).join(" — ") : "");
  }
}

function isWithin(cusp, limits) {
  return ["l2", "l3"].every((leg) => {
    const { min = "0", max } = limits[leg] ?? {};
    return Number(cusp[leg]) >= toNumber(min) && (max === undefined || Number(cusp[leg]) <= toNumber(max));
  });
}
