/** Where poses merge: the fold or the cusp that a joint vector is put on when it comes near, and the poses there. */

import { distance, measured, placesOf } from "./geometry.js";
import { decimal, toNumber } from "./decimals.js";
import { apart, besides, clearanceOf, nearestIn, posesOf, singularNear, vectorOf } from "./kinematics.js";

const REACH = { cusp: 8, fold: 5 }; // pixels in which a joint vector is drawn onto them
const TURN = 0.7; // degrees in which a pose is
const CLUSTER = 10; // degrees within which the poses that have merged are found
const SAME = 0.02; // degrees by which rounded lengths may move a pose
const DIGITS = 15; // of lengths on a fold: its two poses are a thousandth of a pixel apart

/**
 * What a place `[l2, l3]` in the slice of singular curves with these cusps is near to, `{l2, l3, merge}` with the pose and the number
 * of poses that merge in it; null if neither cusp nor fold is. A board has so many pixels for a unit of either length.
 */
export function mergeNear(curves, cusps, place, [unitX, unitY]) {
  const far = ([x, y]) => Math.hypot((x - place[0]) * unitX, (y - place[1]) * unitY);
  const ways = cusps.map(({ l2, l3 }) => far([Number(l2), Number(l3)]));
  const least = Math.min(...ways);
  const index = ways.indexOf(least);
  if (least < REACH.cusp) {
    const { l2, l3, ...pose } = cusps[index];
    return { l2: textOf(l2), l3: textOf(l3), merge: { count: 3, cusp: index, pose: inNumbers(pose) } };
  }
  const lengths = curves && measured(curves.geometry);
  const near = lengths && foldNear(curves, place, [unitX, unitY]);
  return near ? foldOf(lengths, { l1: toNumber(curves.l1), ...near }) : null;
}

const textOf = (length) => String(Number(Number(length).toPrecision(DIGITS)));

const inNumbers = ({ alpha_deg: alpha, theta1_deg: theta }) => ({ alpha_deg: Number(alpha), theta1_deg: Number(theta) });

/** The pose on a drawn curve that is nearest to a place, if it is within reach. */
function foldNear({ components }, [x, y], [unitX, unitY]) {
  let [best, least] = [null, REACH.fold];
  for (const { l2, l3, alpha_deg: alpha, theta1_deg: theta } of components.flatMap(({ strands }) => strands)) {
    for (let k = 1; k < l2.length; k += 1) {
      const [u, v] = [(l2[k] - l2[k - 1]) * unitX, (l3[k] - l3[k - 1]) * unitY];
      const [p, q] = [(x - l2[k - 1]) * unitX, (y - l3[k - 1]) * unitY];
      const share = Math.min(Math.max((u * p + v * q) / (u * u + v * v || 1), 0), 1);
      const way = distance([p, q], [share * u, share * v]);
      if (way >= least) continue;
      least = way;
      best = { alpha_deg: alpha[k - 1] + share * (alpha[k] - alpha[k - 1]), theta1_deg: theta[k - 1] + share * (theta[k] - theta[k - 1]) };
    }
  }
  return best;
}

/** The joint vector on the fold near a pose, on the side where there are poses. */
function foldOf(lengths, near) {
  const singular = singularNear(lengths, near);
  const [, l2, l3] = vectorOf(lengths, besides(lengths, singular)).map(textOf);
  return { l2, l3, merge: { count: 2, pose: inNumbers(singular) } };
}

/** The joint vector of a pose `{l1, alpha_deg, theta1_deg}`: on the fold if it is near one, or of as few decimals as keep the pose. */
export function vectorNear(lengths, pose) {
  if (clearanceOf(lengths, pose) < TURN) return foldOf(lengths, pose);
  const exact = vectorOf(lengths, pose);
  for (let places = placesOf(lengths) - 1; ; places += 1) {
    const [l2, l3] = exact.slice(1).map((length) => decimal(length, places));
    const poses = posesOf(lengths, [pose.l1, Number(l2), Number(l3)]);
    if (places > DIGITS || poses.some((other) => apart(other, pose) < SAME)) return { l2, l3, merge: null };
  }
}

/** All poses of a joint vector in texts, of which some have merged; none if there is no such joint vector. */
export function posesAt(geometry, { l1, l2, l3, merge = null }) {
  const [lengths, vector] = [measured(geometry), [l1, l2, l3].map(toNumber)];
  if (!lengths || !vector.every((length) => length > 0)) return [];
  const poses = posesOf(lengths, vector);
  if (!merge) return poses;
  const one = { l1: vector[0], ...merge.pose };
  for (let k = 0; k < merge.count; k += 1) {
    const index = nearestIn(poses, one);
    if (index >= 0 && apart(poses[index], one) < CLUSTER) poses.splice(index, 1);
  }
  return [...poses, ...Array(merge.count).fill(one)].sort((a, b) => a.alpha_deg - b.alpha_deg || a.theta1_deg - b.theta1_deg);
}
