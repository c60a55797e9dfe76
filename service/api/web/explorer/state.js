/**
 * What the page shows, and its address: `#g=15.91,0,10,17.04,16.54,20.84,ccw&l1=14.98&c=B&v=joint`, or with two
 * triangles `#g=points,0,0,10,0,5,8;sides,3,4,5;cw`; and perhaps `&p=16,20,2`: L2, L3 and the number of a pose; and
 * `&b=14,18,15,`: joint limits of legs 2 and 3, and after two more commas of leg 1; `&h=27,16,20,2`: L1, L2, L3 and
 * the number of the home pose; and `&m=design`, if a drag of the mechanism makes another one; and `&e=-35,24`: from
 * where the joint space is seen.
 */

import { FORMS, LENGTHS, formOf, isSix, numbersOf, triangleOf } from "./geometry.js";

const VIEWS = ["joint", "torus", "space"];
const LEGS = ["l2", "l3", "l1"]; // as their limits are written
export const MODES = ["move", "design"]; // what a drag of the mechanism does

/** The geometry of its text, or null: lengths and orientation, or two triangles, with commas between their parts. */
export function geometryOf(text) {
  const [base, platform, sense = "ccw", more] = (text ?? "").split(";");
  const isSense = ["ccw", "cw"].includes(sense) && more === undefined;
  if (platform !== undefined) {
    const pair = { base: triangleIn(base), platform: triangleIn(platform) };
    if (!isSense || !pair.base || !pair.platform) return null;
    return pair.platform.points ? pair : { ...pair, orientation: sense };
  }
  const parts = base.split(",");
  if (parts.length !== LENGTHS.length + 1 || !["ccw", "cw"].includes(parts.at(-1))) return null;
  const lengths = LENGTHS.map((name, k) => [name, parts[k].trim()]);
  return { ...Object.fromEntries(lengths), orientation: parts.at(-1) };
}

/** The triangle of its text: the name of its spelling, and its numbers. */
function triangleIn(text) {
  const [form, ...numbers] = text.split(",").map((part) => part.trim());
  return FORMS[form]?.length === numbers.length ? triangleOf(form, numbers) : null;
}

export function geometryText(geometry) {
  if (isSix(geometry)) return [...LENGTHS.map((name) => geometry[name]), geometry.orientation].join(",");
  const triangles = [geometry.base, geometry.platform].map((triangle) => [formOf(triangle), ...numbersOf(triangle)].join(","));
  return [...triangles, ...(geometry.orientation === "cw" ? ["cw"] : [])].join(";");
}

/** The state of an address, or null if it has no geometry. */
export function stateOf(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const geometry = geometryOf(given.get("g"));
  if (!geometry) return null;
  const view = VIEWS.includes(given.get("v")) ? given.get("v") : VIEWS[0];
  const [at, limits, home] = [vectorOf(given.get("p")), limitsOf(given.get("b")), homeOf(given.get("h"))];
  const mode = MODES.includes(given.get("m")) ? given.get("m") : MODES[0];
  return { geometry, l1: given.get("l1") ?? "1", cusp: numberOf(given.get("c")), view, at, limits, home, mode, eye: given.get("e") };
}

/** Why an address has no state, for the person who followed the link. */
export function faultOf(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, "")).get("g");
  if (given === null) return "This link names no manipulator: it has no “g=…”. The first example is shown.";
  const count = given.split(",").length;
  const hint = count > 7 ? " If the numbers have decimal commas, write points: 15.91, not 15,91." : "";
  const parts = "six numbers (a2x, a3x, a3y, d1, d2, d3) and ccw or cw, or two triangles such as equilateral,10;sides,3,4,5,";
  return `This link cannot be read: g=${given} has ${count} part${count === 1 ? "" : "s"}, but ${parts} are expected.${hint} The first example is shown.`;
}

export function hashOf({ geometry, l1, cusp, view, at, limits, home, mode, eye }) {
  const parts = [["g", geometryText(geometry)], ["l1", l1], ["c", letterOf(cusp)], ["v", view]];
  if (at) parts.push(["p", [at.l2, at.l3, at.pose + 1].join(",")]);
  if (limits) parts.push(["b", LEGS.filter((leg) => leg !== "l1" || limits.l1).flatMap((leg) => [limits[leg]?.min ?? "", limits[leg]?.max ?? ""]).join(",")]);
  if (home) parts.push(["h", [home.l1, home.l2, home.l3, home.pose + 1].join(",")]);
  if (mode !== MODES[0]) parts.push(["m", mode]);
  if (eye && view === "space") parts.push(["e", eye]);
  return `#${parts.map(([name, text]) => `${name}=${encodeURIComponent(text).replaceAll("%2C", ",").replaceAll("%3B", ";")}`).join("&")}`;
}

/** The letters of the cusps in the order of the table: 0 → A, 25 → Z, 26 → AA. */
export function letterOf(index) {
  const rest = Math.floor(index / 26);
  return (rest > 0 ? letterOf(rest - 1) : "") + String.fromCharCode(65 + (index % 26));
}

/** A joint vector and the index of its pose; null if there is none. */
function vectorOf(text) {
  const [l2, l3, pose = "1"] = (text ?? "").split(",");
  return l2 && l3 ? { l2, l3, pose: Math.max(Math.trunc(Number(pose)) || 1, 1) - 1 } : null;
}

/** A pose with its lengths; null if there is none. */
function homeOf(text) {
  const [l1, ...rest] = (text ?? "").split(",");
  const at = vectorOf(rest.join(","));
  return l1 && at ? { l1, ...at } : null;
}

/** Joint limits `{l2: {min, max}, l3, l1}` with the ends that are given; null if there are none. */
export function limitsOf(text) {
  const ends = (text ?? "").split(",").map((end) => end.trim());
  const bounds = (k) => Object.fromEntries([["min", ends[k]], ["max", ends[k + 1]]].filter(([, end]) => end));
  const legs = LEGS.map((leg, k) => [leg, bounds(2 * k)]).filter(([, bound]) => Object.keys(bound).length > 0);
  return legs.length > 0 ? Object.fromEntries(legs) : null;
}

function numberOf(letters) {
  if (!/^[A-Z]{1,2}$/.test(letters ?? "")) return 0;
  return [...letters].reduce((number, letter) => 26 * number + letter.charCodeAt(0) - 64, 0) - 1;
}
