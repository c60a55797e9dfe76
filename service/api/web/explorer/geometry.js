/** Plane geometry of the manipulator in floats, for drawing; everything that counts comes from the service. */

import { decimal, gridPlaces, toNumber } from "./decimals.js";

export const LENGTHS = ["a2x", "a3x", "a3y", "d1", "d2", "d3"];

const DEGREES = Math.PI / 180;

/** The lengths as numbers, or null if they describe nothing that can be drawn. */
export function measured(geometry) {
  const lengths = Object.fromEntries(LENGTHS.map((name) => [name, toNumber(geometry[name])]));
  const { d1, d2, d3 } = lengths;
  const isFinite = Object.values(lengths).every(Number.isFinite);
  if (!isFinite || Math.min(d1, d2, d3) <= 0 || 2 * Math.max(d1, d2, d3) > (d1 + d2 + d3) * (1 + 1e-12)) return null;
  return { ...lengths, sense: geometry.orientation === "cw" ? -1 : 1 };
}

export function basePoints({ a2x, a3x, a3y }) {
  return [[0, 0], [a2x, 0], [a3x, a3y]];
}

/** B1, B2, B3 of the platform with B1 at a place and B1B2 in a direction, in radians. */
export function platformPoints({ d1, d2, d3, sense }, [x, y], alpha) {
  const along = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1);
  const across = sense * Math.sqrt(Math.max(d3 * d3 - along * along, 0));
  const [c, s] = [Math.cos(alpha), Math.sin(alpha)];
  return [[x, y], [x + d1 * c, y + d1 * s], [x + along * c - across * s, y + along * s + across * c]];
}

/** The place of B1 and the direction of B1B2 at a pose with its angles in degrees. */
export function placeOf({ l1, alpha_deg: alpha, theta1_deg: theta1 }) {
  const leg = toNumber(l1); // text, or a number on a path
  return { b1: [leg * Math.cos(theta1 * DEGREES), leg * Math.sin(theta1 * DEGREES)], alpha: alpha * DEGREES };
}

export const distance = ([x, y], [u, v]) => Math.hypot(u - x, v - y);

/** The number of decimal places on whose grid a drawing of these lengths snaps. */
export function placesOf(lengths) {
  return gridPlaces(Math.max(...LENGTHS.map((name) => Math.abs(lengths[name]))));
}

/**
 * The geometry after a point was dragged, on the grid of decimals, or null if there is none.
 * A corner of the platform takes its two sides with it, and turns the platform over where it crosses the third.
 */
export function dragged(geometry, name, to, [b1, b2, b3], places) {
  const on = (value) => decimal(value, places);
  const changed = {
    A2: () => ({ a2x: on(to[0]) }),
    A3: () => ({ a3x: on(to[0]), a3y: on(to[1]) }),
    B2: () => ({ d1: on(distance(b1, to)), d2: on(distance(to, b3)), orientation: senseOf(b1, to, b3) }),
    B3: () => ({ d2: on(distance(b2, to)), d3: on(distance(to, b1)), orientation: senseOf(b1, b2, to) }),
  }[name]();
  const next = { ...geometry, ...changed };
  const lengths = measured(next);
  const [a1, a2, a3] = lengths ? basePoints(lengths) : [];
  const isApart = lengths && distance(a1, a2) > 0 && distance(a1, a3) > 0 && distance(a2, a3) > 0;
  return isApart ? next : null;
}

function senseOf([x, y], [u, v], [p, q]) {
  return (u - x) * (q - y) - (v - y) * (p - x) < 0 ? "cw" : "ccw";
}

/** The direction of B1B2 that keeps the other corner, which is not dragged, in its direction from B1. */
export function heldDirection(lengths, name, [b1, b2, b3]) {
  const seen = ([x, y]) => Math.atan2(y - b1[1], x - b1[0]);
  if (name === "B3") return seen(b2);
  const [, , corner] = platformPoints(lengths, [0, 0], 0);
  return seen(b3) - Math.atan2(corner[1], corner[0]);
}
