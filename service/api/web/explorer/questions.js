/** What the page asks about a state: paths and questions of the public API. */

export const [WHILE_MOVING, AT_REST] = [15, 30]; // digits
const COARSE = "0.003"; // tolerance of the curves while something moves
const TOLERANCES = [[0, "0.001"], [4, "0.0001"], [40, "0.00001"], [400, "0.000001"]]; // by magnification
export const SAMPLES = 201; // of a loop

/** The tolerance of curves that are magnified. */
export function toleranceAt(factor) {
  return (TOLERANCES.findLast(([least]) => factor >= least) ?? TOLERANCES[0])[1];
}

export const pictureOf = ({ geometry, l1 }) => ["v1/singular-curves", { geometry, l1, digits: WHILE_MOVING, tolerance: COARSE }];
export const tableOf = ({ geometry, l1 }) => ["v1/cusp-tables", { geometry, l1, digits: AT_REST }];
export const curvesOf = ({ geometry, l1 }, tolerance = toleranceAt(0)) => ["v1/singular-curves", { geometry, l1, tolerance }];
export const censusOf = ({ geometry }) => ["v1/censuses", { geometry, digits: WHILE_MOVING }];
/** The cusp curves at the length of the slice and at another one. */
export const cuspCurvesOf = ({ geometry, l1 }, other) => ["v1/cusp-curves", { geometry, l1: [other, l1], digits: WHILE_MOVING }];
export const marginOf = ({ geometry, l1 }, tolerance) => ["v1/margins", { geometry, l1, tolerance }];
/** Whether the mode can change: in the slice, or in the range of L1 if that is limited; with thresholds, `{clearance, tolerance}`. */
export const modesOf = ({ geometry, l1, limits }, thresholds = {}) => {
  const range = limits?.l1 && { from: limits.l1.min, to: limits.l1.max ?? null };
  return ["v1/assembly-modes", { geometry, ...(range ? { range } : { l1 }), ...limitsIn(freeLimits(limits)), ...thresholds }];
};
export const posesOf = ({ geometry, l1, at: { l2, l3 } }) => ["v1/poses", { geometry, l1, l2, l3, digits: WHILE_MOVING }];
export const loopOf = ({ geometry, l1, limits }, cusp) => ["v1/paths", { geometry, l1, cusp, ...limitsIn(freeLimits(limits)), samples: SAMPLES, digits: WHILE_MOVING }];

/** The limits of the legs that are not held. */
export const freeLimits = (limits) => Object.fromEntries(Object.entries(limits ?? {}).filter(([leg]) => leg !== "l1"));

export const limitsIn = (limits) => (Object.keys(limits).length > 0 ? { limits } : {});
