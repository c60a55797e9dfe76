/** Plane geometry of the manipulator in floats, for drawing; everything that counts comes from the service. */

import { decimal, gridPlaces, toNumber } from "./decimals.js";
import { respelledExactly } from "./surds.js";

export const LENGTHS = ["a2x", "a3x", "a3y", "d1", "d2", "d3"];

const DEGREES = Math.PI / 180;

/** The numbers of a triangle by spelling, as the service names them. */
export const FORMS = {
  points: ["[0][0]", "[0][1]", "[1][0]", "[1][1]", "[2][0]", "[2][1]"],
  sides: ["[0]", "[1]", "[2]"],
  equilateral: [""],
  circumradius: [""],
};

/** The spelling of a triangle: its one member. */
export const formOf = (triangle) => Object.keys(triangle)[0];

/** The triangle with these texts as its numbers. */
export function triangleOf(form, texts) {
  const content = { points: () => [0, 2, 4].map((k) => texts.slice(k, k + 2)), sides: () => texts }[form];
  return { [form]: content ? content() : texts[0] };
}

export const numbersOf = (triangle) => [triangle[formOf(triangle)]].flat(2);

/** Whether a geometry is six numbers, rather than two triangles. */
export const isSix = (geometry) => LENGTHS[0] in geometry;

/** A geometry in any spelling, or in the canonical form of documents, as two triangles; the base keeps its sense. */
export function pairOf(geometry) {
  const { base, platform, orientation = "ccw" } = geometry;
  if (isSix(geometry)) {
    const [a2x, a3x, a3y, ...sides] = LENGTHS.map((name) => geometry[name]);
    return { base: { points: [["0", "0"], [a2x, "0"], [a3x, a3y]] }, platform: { sides }, orientation };
  }
  if (!Array.isArray(base)) return platform.points ? { base, platform } : { base, platform, orientation };
  const sides = { sides: base };
  const clockwise = geometry.base_orientation === "cw" && respelledExactly(sides, "points", -1);
  return { base: clockwise || sides, platform: { sides: platform }, orientation: geometry.platform_orientation };
}

/** The same geometry with its base or platform in another spelling, or for "lengths" as six numbers. */
export function respelled(geometry, name, form) {
  const pair = pairOf(geometry);
  const orientation = orientationOf(pair);
  if (form === "lengths") {
    const [, [a2x], [a3x, a3y]] = inFrame(pair.base, "points").points;
    const numbers = [a2x, a3x, a3y, ...spelledAs(pair.platform, "sides").sides];
    return { ...Object.fromEntries(numbers.map((text, k) => [LENGTHS[k], text])), orientation };
  }
  const sense = name === "base" ? undefined : orientation;
  const { base, platform } = { ...pair, [name]: spelledAs(pair[name], form, sense) };
  return platform.points ? { base, platform } : { base, platform, orientation };
}

const spelledAs = (triangle, form, sense) => (form in triangle ? triangle : inFrame(triangle, form, sense));

/** A triangle in a spelling, by points with corner 1 at 0 and corner 2 on the x-axis; of empty numbers if it has none. */
function inFrame(triangle, form, sense = senseOf(...cornersOf(triangle))) {
  return respelledExactly(triangle, form, sense === "cw" ? -1 : 1) ?? triangleOf(form, FORMS[form].map(() => ""));
}

function orientationOf({ platform, orientation }) {
  return platform.points ? senseOf(...cornersOf(platform)) : orientation;
}

/** A geometry in words. */
export function described(geometry) {
  const { base, platform, orientation } = pairOf(geometry);
  const spoken = (parts) => parts.map(([name, text]) => `${name}\u00a0=\u00a0${text.replace("-", "−")}`).join(", ");
  if (isSix(geometry)) return spoken(LENGTHS.map((name) => [name, geometry[name]]));
  const triangles = [["base", base], ["platform", platform]].map(([name, triangle]) => [name, `${formOf(triangle)} ${numbersOf(triangle).join(" ")}`]);
  return spoken([...triangles, ...(orientation === "cw" ? [["orientation", "cw"]] : [])]);
}

/** The corners of a triangle as numbers; by sides, corner 1 is at 0, corner 2 on the x-axis, corner 3 above it. */
function cornersOf(triangle) {
  const numbers = numbersOf(triangle).map(toNumber);
  if (triangle.points) return [0, 2, 4].map((k) => numbers.slice(k, k + 2));
  const [a, b, c] = triangle.sides ? numbers : Array(3).fill(numbers[0] * (triangle.circumradius ? Math.sqrt(3) : 1));
  return platformPoints({ d1: a, d2: b, d3: c, sense: 1 }, [0, 0], 0);
}

/**
 * The lengths in the article's frame as numbers, or null if they describe nothing that can be drawn; and the `frame` in
 * which a base by points is drawn, else null.
 */
export function measured(geometry) {
  const { base, platform, orientation } = pairOf(geometry);
  const corners = cornersOf(platform);
  const [d1, d2, d3] = [0, 1, 2].map((k) => distance(corners[k], corners[(k + 1) % 3]));
  const frame = frameOf(cornersOf(base));
  const [[a2x], [a3x, a3y]] = isSix(geometry) ? cornersOf(base).slice(1) : cornersOf(base).slice(1).map(frame.inside);
  const isWhole = [base, platform].every((triangle) => !triangle.sides || isTriangle(triangle.sides.map(toNumber)));
  if (!isWhole || ![a2x, a3x, a3y, d1, d2, d3].every(Number.isFinite) || Math.min(d1, d2, d3) <= 0) return null;
  const sense = platform.points ? senseOf(...corners) : orientation;
  return { a2x, a3x, a3y, d1, d2, d3, sense: sense === "cw" ? -1 : 1, frame: base.points && !isSix(geometry) ? frame : null };
}

const isTriangle = (sides) => Math.min(...sides) > 0 && 2 * Math.max(...sides) <= sides.reduce((sum, side) => sum + side) * (1 + 1e-12);

/** The frame of a triangle, corner 1 at 0 and corner 2 on the x-axis: points from `outside` into it, and back. */
function frameOf([[x, y], [u, v]]) {
  const length = Math.hypot(u - x, v - y);
  const [c, s] = [(u - x) / length, (v - y) / length];
  return {
    inside: ([p, q]) => [c * (p - x) + s * (q - y), c * (q - y) - s * (p - x)],
    outside: ([p, q]) => [x + c * p - s * q, y + s * p + c * q],
  };
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
 * A corner of a triangle by points is moved in its own frame; else a base becomes one of points, and a corner of the
 * platform takes its two sides with it, and turns the platform over where it crosses the third.
 */
export function dragged(geometry, name, to, [b1, b2, b3], places) {
  const on = (value) => decimal(value, places);
  const corner = Number(name[1]) - 1;
  const pair = pairOf(geometry);
  const changed = () => {
    const triangle = name.startsWith("A") ? "base" : "platform";
    if (name.startsWith("A") || pair.platform.points) {
      const own = pair[triangle].points ? pair : respelled(pair, triangle, "points");
      const place = triangle === "platform" ? frameOf([b1, b2]).inside(to) : [to[0], corner === 1 ? 0 : to[1]];
      const moved = frameOf(cornersOf(own[triangle])).outside(place).map(on);
      return { ...own, [triangle]: { points: own[triangle].points.with(corner, moved) } };
    }
    const sides = [...spelledAs(pair.platform, "sides").sides];
    const [before, after] = corner === 1 ? [b1, b3] : [b2, b1];
    [sides[corner - 1], sides[corner]] = [on(distance(before, to)), on(distance(to, after))];
    return { ...pair, platform: { sides }, orientation: corner === 1 ? senseOf(b1, to, b3) : senseOf(b1, b2, to) };
  };
  const six = {
    A2: () => ({ a2x: on(to[0]) }),
    A3: () => ({ a3x: on(to[0]), a3y: on(to[1]) }),
  };
  const next = isSix(geometry) ? { ...geometry, ...(six[name]?.() ?? sixSides(changed())) } : changed();
  const lengths = measured(next);
  const [a1, a2, a3] = lengths ? basePoints(lengths) : [];
  const isApart = lengths && distance(a1, a2) > 0 && distance(a1, a3) > 0 && distance(a2, a3) > 0;
  return isApart ? next : null;
}

const sixSides = ({ platform: { sides: [d1, d2, d3] }, orientation }) => ({ d1, d2, d3, orientation });

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
