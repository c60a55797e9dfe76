/**
 * The cusp curves, which are the edges of the singular surface, drawn: through the exact points that the service has
 * proved to be on them, along J = E = 0 in floats.
 */

import { Legs } from "./legs.js";

const DEGREES = Math.PI / 180;
const TURN = 2 * Math.PI;
const [SHORT, LONG] = [1e-4, 0.12]; // steps, in radians or lengths over the size of the manipulator
const BEND = 0.25; // radians that the direction may turn in a step
const STEPS = 600; // from point to point
const CLOSE = 1e-3; // at which a point is reached, in the same measure

/**
 * The lines of a document of cusp curves: `[{name, from, to, points, isWhole}]` with points [L1, L2, L3] whose fixed length
 * is from 0 to `reach`; not whole if between exact points a chord had to be drawn.
 */
export function edgesOf(triangles, { fixed_leg: leg, curves }, reach) {
  const legs = new Legs(triangles, leg);
  return curves.map(({ name, from, to, points }) => {
    const poses = points.map((point) => poseOf(point, leg));
    const line = [];
    let isWhole = true;
    const join = (start, end, way) => {
      const found = followed(legs, start, end, way, reach);
      isWhole &&= found !== null;
      return found ?? [start, end].filter(Boolean);
    };
    const first = poses[0];
    if (first) line.push(...join(first, endOf(from, leg), -1).reverse());
    poses.slice(1).forEach((pose, k) => line.push(...join(poses[k], pose, 1)));
    if (first) line.push(...join(poses.at(-1), endOf(to, leg), 1));
    const within = line.filter(([, , length]) => length >= 0 && length <= reach * (1 + 1e-9));
    return { name, from: from.kind, to: to.kind, ends: [from, to].map((end) => end[`l${leg}`]), isWhole, points: within.map((pose) => {
      legs.at(...pose);
      return legs.joints;
    }) };
  }).filter(({ points }) => points.length > 1);
}

/** The degenerate poses at which cusp curves end: `[{kind, length, place}]`, each once. */
export function eventsOf({ fixed_leg: leg, curves }) {
  const found = new Map();
  for (const end of curves.flatMap(({ from, to }) => [from, to])) {
    for (const event of end.events ?? []) {
      const place = [1, 2, 3].map((k) => Number(k === leg ? end[`l${leg}`] : event[`l${k}`]));
      found.set([event.kind, event.alpha_deg, end[`l${leg}`], ...place].join(), { kind: event.kind, length: end[`l${leg}`], place });
    }
  }
  return [...found.values()];
}

function poseOf(point, leg) {
  return [Number(point.alpha_deg) * DEGREES, Number(point[`theta${leg}_deg`]) * DEGREES, Number(point[`l${leg}`])];
}

/** The pose at an end of a curve, if it is a single one. */
function endOf(end, leg) {
  if (end.events?.length !== 1) return null;
  return poseOf({ ...end.events[0], [`l${leg}`]: end[`l${leg}`] }, leg);
}

/** The poses from one on a cusp curve to another on it, or as far as there is something to draw; null if they get lost. */
function followed(legs, start, end, way, reach) {
  const poses = [start];
  let [at, step] = [start, LONG / 4];
  let heading = legs.tangent(at);
  if (heading[2] * way < 0) heading = heading.map((x) => -x);
  for (let k = 0; k < STEPS; k += 1) {
    if (at[2] < 0 || at[2] > reach) return clipped(legs, poses, reach);
    if (end) {
      const left = apart(legs, at, end);
      if (left < CLOSE) return [...poses, end];
      step = Math.min(step, left);
    }
    const scale = [1, 1, legs.size];
    const isNear = legs.ontoEdge(...at.map((x, i) => x + step * scale[i] * heading[i]));
    const next = [legs.alpha, legs.theta, legs.length];
    const moved = apart(legs, at, next);
    const after = isNear ? legs.tangent(next) : heading;
    const along = after[0] * heading[0] + after[1] * heading[1] + after[2] * heading[2];
    const isSmooth = isNear && Math.abs(along) > Math.cos(BEND) && moved < 1.5 * step && moved > 0.5 * step;
    if (!isSmooth) {
      step /= 2;
      if (step < SHORT) return null;
      continue;
    }
    heading = along < 0 ? after.map((x) => -x) : after;
    at = next;
    poses.push(at);
    step = Math.min(LONG, 1.6 * step);
  }
  return end ? null : poses;
}

/** How far two poses are apart, in radians or lengths over the size of the manipulator. */
function apart(legs, one, other) {
  const way = one.map((x, k) => other[k] - x);
  return Math.hypot(way[0] - TURN * Math.round(way[0] / TURN), way[1] - TURN * Math.round(way[1] / TURN), way[2] / legs.size);
}

/** A line whose last pose is beyond 0 or `reach`, cut there. */
function clipped(legs, poses, reach) {
  const [one, other] = poses.slice(-2);
  if (!other) return poses;
  const at = other[2] < 0 ? 0 : reach;
  const share = (at - one[2]) / (other[2] - one[2]);
  const pose = one.map((x, k) => x + share * (other[k] - x));
  return [...poses.slice(0, -1), legs.ontoEdge(...pose, true) ? [legs.alpha, legs.theta, at] : pose];
}
