/** The selected cusp while L1 changes: from picture to picture the nearest to where it is expected, at rest by its proved curve. */

import { toNumber } from "./decimals.js";
import { nearestIn } from "./kinematics.js";

export class Following {
  #places = []; // of the cusp, at most two, the newest last: {l1, alpha_deg, theta1_deg}
  #known = null; // {geometry, l1, cusp}: where its number was chosen or proved

  /** Follows a cusp from a slice on. */
  start(l1, cusp) {
    this.#places = cusp ? [placeOf(l1, cusp)] : [];
  }

  forget() {
    [this.#places, this.#known] = [[], null];
  }

  /** The number in another slice of the cusp that is followed; null if none is. */
  numberIn({ l1, cusps = [] }) {
    if (this.#places.length === 0 || cusps.length === 0) return null;
    const cusp = nearestIn(cusps, this.#expected(toNumber(l1)));
    const place = placeOf(l1, cusps[cusp]);
    this.#places = place.l1 === this.#places.at(-1).l1 ? [place] : [this.#places.at(-1), place];
    return cusp;
  }

  /** As far on as it has come with the last change of L1, at most. */
  #expected(l1) {
    const [before, last] = this.#places;
    if (!last) return before;
    const share = Math.min(Math.max((l1 - last.l1) / (last.l1 - before.l1), -1), 1);
    return Object.fromEntries(["alpha_deg", "theta1_deg"].map((name) => [name, last[name] + share * turn(last[name] - before[name])]));
  }

  /** Takes the number of the cusp in a slice of a geometry, in texts. */
  know(known) {
    this.#known = known;
  }

  /** From where its curve would tell the number in another slice: null if that is known, or cannot be. */
  since({ geometry, l1 }) {
    const known = this.#known;
    return known?.geometry === geometry && known.l1 !== l1 ? known : null;
  }
}

/** What became of a cusp of one slice in another, by a document of cusp curves at both: `{cusp}`, or the `{end}` of its curve; or null. */
export function fateOf({ curves }, { l1, cusp }, to) {
  const at = (curve, length) => curve.points.find((point) => Math.abs(toNumber(point.l1) / toNumber(length) - 1) < 1e-12);
  const curve = curves.find((one) => at(one, l1)?.cusp === cusp + 1);
  if (!curve) return null;
  const point = at(curve, to);
  return point ? { cusp: point.cusp - 1 } : { end: toNumber(to) > toNumber(l1) ? curve.to : curve.from };
}

const placeOf = (l1, { alpha_deg: alpha, theta1_deg: theta }) => ({ l1: toNumber(l1), alpha_deg: Number(alpha), theta1_deg: Number(theta) });

const turn = (degrees) => degrees - 360 * Math.round(degrees / 360);
