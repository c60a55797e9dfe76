/**
 * Poses in doubles, for what moves under a finger: all of a joint vector, how near a singular one is, where its legs meet.
 * At rest the page has those of the service, which are proved.
 */

import { basePoints, platformPoints } from "./geometry.js";

const DEGREES = Math.PI / 180;
const ROUNDS = 100; // of the iteration for the roots, which takes about ten, and more at a cusp
const MERGED = 1e-4; // radians off the circle at which two roots are a double one: 1e-8 of a length
const CROSSED = 1e-7; // sine of the angle between two lines that are taken as parallel
const ASIDE = 1e-5; // radians from a singular pose to those that merge in it

/** The lengths `[l1, l2, l3]` of a pose. */
export function vectorOf(lengths, pose) {
  const corners = cornersOf(lengths, pose);
  return basePoints(lengths).map(([x, y], k) => Math.hypot(corners[k][0] - x, corners[k][1] - y));
}

const cornersOf = (lengths, { l1, alpha_deg: alpha, theta1_deg: theta }) =>
  platformPoints(lengths, [l1 * Math.cos(theta * DEGREES), l1 * Math.sin(theta * DEGREES)], alpha * DEGREES);

/** All poses of a joint vector, ordered by α, then θ1, as the service has them; those that have merged are there twice or thrice. */
export function posesOf(lengths, [l1, l2, l3]) {
  const system = systemOf(lengths, [l1, l2, l3]);
  const angles = rootsOnCircle(coefficientsOf(system.condition)).sort((a, b) => a - b);
  const poses = angles.map((alpha, k) => {
    const isTwin = k > 0 && alpha - angles[k - 1] < 1e-3;
    const place = system.placeAt(alpha, isTwin ? -1 : 1);
    return place && improved(lengths, [l1, l2, l3], { l1, alpha_deg: alpha / DEGREES, theta1_deg: Math.atan2(place[1], place[0]) / DEGREES });
  });
  const isTrue = (pose) => vectorOf(lengths, pose).every((length, k) => Math.abs(length - [l1, l2, l3][k]) < 1e-5 * (l1 + l2 + l3));
  return poses.filter((pose) => pose && isTrue(pose)).sort((one, other) => one.alpha_deg - other.alpha_deg || one.theta1_deg - other.theta1_deg);
}

/**
 * With v2 = B2 − B1 − A2 and v3 alike, both known where α is, l2² − l1² = 2 B1·v2 + |v2|²: two lines on which B1 lies.
 * They meet on the circle of B1 where |r2 v3 − r3 v2|² = l1² (v2 × v3)², of degree 3 in cos α and sin α.
 */
function systemOf(lengths, [l1, ...others]) {
  const [, ...feet] = basePoints(lengths);
  const linesAt = (alpha) => platformPoints(lengths, [0, 0], alpha).slice(1).map(([x, y], k) => {
    const v = [x - feet[k][0], y - feet[k][1]];
    return { v, r: (others[k] ** 2 - l1 * l1 - v[0] * v[0] - v[1] * v[1]) / 2 };
  });
  const across = ([one, other]) => one.v[0] * other.v[1] - one.v[1] * other.v[0];
  const both = ([one, other]) => [0, 1].map((axis) => one.r * other.v[axis] - other.r * one.v[axis]);
  return {
    condition: (alpha) => {
      const lines = linesAt(alpha);
      const [x, y] = both(lines);
      return x * x + y * y - (l1 * across(lines)) ** 2;
    },
    /** B1 at a root; where both lines are one, it meets the circle on either side. */
    placeAt: (alpha, side) => {
      const lines = linesAt(alpha);
      const sizes = lines.map(({ v }) => Math.hypot(...v));
      const determinant = across(lines);
      if (Math.abs(determinant) > CROSSED * sizes[0] * sizes[1]) {
        const [x, y] = both(lines);
        return [y / determinant, -x / determinant];
      }
      const { v, r } = lines[sizes[0] > sizes[1] ? 0 : 1];
      const square = v[0] * v[0] + v[1] * v[1];
      if (!(square > 0)) return null;
      const half = (side * Math.sqrt(Math.max(l1 * l1 - (r * r) / square, 0))) / Math.sqrt(square);
      return [(r * v[0]) / square - half * v[1], (r * v[1]) / square + half * v[0]];
    },
  };
}

/** The coefficients of zᵏ, k = 0 … 6, of z³ f for a real f of degree 3 in the angle of z, from its values at eight angles. */
function coefficientsOf(f) {
  const values = Array.from({ length: 8 }, (_, j) => f((j * Math.PI) / 4));
  return Array.from({ length: 7 }, (_, k) => [0, 1].map((part) =>
    values.reduce((sum, value, j) => sum + (value / 8) * [Math.cos, (x) => -Math.sin(x)][part](((k - 3) * j * Math.PI) / 4), 0)));
}

/** The angles of the roots on the unit circle, by the iteration of Ehrlich and Aberth for all roots at once. */
function rootsOnCircle(coefficients) {
  const most = Math.max(...coefficients.map(([x, y]) => Math.hypot(x, y)));
  if (!(most > 0)) return [];
  let c = coefficients.map(([x, y]) => [x / most, y / most]);
  while (c.length > 1 && Math.hypot(...c.at(-1)) < 1e-14) c = c.slice(1, -1); // the first is its conjugate
  const degree = c.length - 1;
  const roots = Array.from({ length: Math.max(degree, 0) }, (_, k) => {
    const [size, turn] = [k % 2 ? 1.3 : 0.8, (2 * Math.PI * k) / degree + 0.4];
    return [size * Math.cos(turn), size * Math.sin(turn)];
  });
  for (let round = 0, change = 1; round < ROUNDS && change > 1e-15; round += 1) {
    change = 0;
    roots.forEach(([x, y], k) => {
      const [value, slope] = valueAt(c, x, y);
      if (value[0] === 0 && value[1] === 0) return;
      // Δ = 1 / (P′/P − Σ 1/(z − zⱼ))
      let [u, v] = quotient(slope, value);
      roots.forEach(([p, q], j) => {
        if (j === k) return;
        const [r, s] = quotient([1, 0], [x - p || 1e-30, y - q]);
        [u, v] = [u - r, v - s];
      });
      const [dx, dy] = quotient([1, 0], [u, v]);
      if (!Number.isFinite(dx + dy)) return;
      roots[k] = [x - dx, y - dy];
      change = Math.max(change, Math.hypot(dx, dy) / Math.hypot(x, y));
    });
  }
  return roots.filter((root) => Math.abs(Math.log(Math.hypot(...root))) < MERGED).map(([x, y]) => Math.atan2(y, x));
}

function valueAt(c, x, y) {
  let [a, b, s, t] = [0, 0, 0, 0];
  for (let k = c.length - 1; k >= 0; k -= 1) {
    [s, t] = [s * x - t * y + a, s * y + t * x + b];
    [a, b] = [a * x - b * y + c[k][0], a * y + b * x + c[k][1]];
  }
  return [[a, b], [s, t]];
}

function quotient([a, b], [c, d]) {
  const square = c * c + d * d;
  return [(a * c + b * d) / square, (b * c - a * d) / square];
}

/** A pose after two steps of Newton's method on the lengths, unless they lead away, as they may where poses merge. */
function improved(lengths, vector, pose) {
  const off = (at) => vectorOf(lengths, at).slice(1).map((length, k) => (vector[k + 1] ** 2 - length ** 2) / 2);
  let best = pose;
  for (let round = 0; round < 2; round += 1) {
    const [[a, b], [c, d]] = slopesAt(lengths, best);
    const [u, v] = off(best);
    const determinant = a * d - b * c;
    const next = moved(best, [(u * d - v * b) / determinant, (a * v - c * u) / determinant]);
    const isBetter = Math.hypot(...off(next)) < Math.hypot(...off(best)) && Math.abs(next.alpha_deg - best.alpha_deg) < 0.1;
    if (!isBetter) return best;
    best = next;
  }
  return best;
}

const moved = (pose, [theta, alpha]) => ({ ...pose, theta1_deg: pose.theta1_deg + theta / DEGREES, alpha_deg: pose.alpha_deg + alpha / DEGREES });

/** How l2²/2 and l3²/2 change with θ1 and α in radians, l1 being kept: `[[∂θ, ∂α] of l2, the same of l3]`. */
function slopesAt(lengths, pose) {
  const [b1, ...corners] = cornersOf(lengths, pose);
  return basePoints(lengths).slice(1).map((foot, k) => {
    const [x, y] = [corners[k][0] - foot[0], corners[k][1] - foot[1]];
    return [y * b1[0] - x * b1[1], y * (corners[k][0] - b1[0]) - x * (corners[k][1] - b1[1])];
  });
}

/** Zero where the pose is singular. */
function determinantAt(lengths, pose) {
  const [[a, b], [c, d]] = slopesAt(lengths, pose);
  return a * d - b * c;
}

function gradientAt(lengths, pose) {
  const step = 1e-5;
  return [[step, 0], [0, step]].map(([x, y]) => (determinantAt(lengths, moved(pose, [x, y])) - determinantAt(lengths, moved(pose, [-x, -y]))) / (2 * step));
}

/** Degrees from a pose to the nearest singular one with the same l1, to first order. */
export function clearanceOf(lengths, pose) {
  return Math.abs(determinantAt(lengths, pose)) / Math.hypot(...gradientAt(lengths, pose)) / DEGREES;
}

/** The singular pose near one. */
export function singularNear(lengths, pose) {
  let best = pose;
  for (let round = 0; round < 6; round += 1) {
    const [u, v] = gradientAt(lengths, best);
    const share = -determinantAt(lengths, best) / (u * u + v * v);
    if (!Number.isFinite(share)) return best;
    best = moved(best, [share * u, share * v]);
  }
  return best;
}

/** One of the two poses that merge in a singular one, so near to it that a picture does not tell them apart. */
export function besides(lengths, singular) {
  const [one, other] = slopesAt(lengths, singular);
  const [a, b] = Math.hypot(...one) > Math.hypot(...other) ? one : other;
  const size = Math.hypot(a, b);
  return moved(singular, [(-ASIDE * b) / size, (ASIDE * a) / size]); // the way in which no length changes
}

/** The degrees between two poses with the same l1. */
export function apart(one, other) {
  const turn = (name) => Math.abs(((Number(one[name]) - Number(other[name]) + 540) % 360 + 360) % 360 - 180);
  return Math.hypot(turn("alpha_deg"), turn("theta1_deg"));
}

/** The index of the pose that is nearest to one; −1 if there are none. */
export function nearestIn(poses, pose) {
  const ways = poses.map((other) => apart(other, pose));
  return ways.indexOf(Math.min(...ways));
}

/** The point that is nearest to the lines of the three legs, in which they meet at a singular pose; null if they are parallel. */
export function meetingOf(feet, corners) {
  const normals = feet.map(([x, y], k) => {
    const [u, v] = [corners[k][0] - x, corners[k][1] - y];
    const size = Math.hypot(u, v) || 1;
    return { n: [v / size, -u / size], at: (v * x - u * y) / size };
  });
  const sum = (f) => normals.reduce((total, normal) => total + f(normal), 0);
  const [xx, xy, yy] = [sum(({ n }) => n[0] * n[0]), sum(({ n }) => n[0] * n[1]), sum(({ n }) => n[1] * n[1])];
  const [x, y] = [sum(({ n, at }) => n[0] * at), sum(({ n, at }) => n[1] * at)];
  const determinant = xx * yy - xy * xy;
  return determinant > 1e-6 ? [(x * yy - y * xy) / determinant, (y * xx - x * xy) / determinant] : null;
}
