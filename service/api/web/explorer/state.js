/**
 * What the page shows, and its address: `#g=15.91,0,10,17.04,16.54,20.84,ccw&l1=14.98&c=B&v=joint`, and perhaps
 * `&p=16,20,2`: L2, L3 and the number of a pose.
 */

import { LENGTHS } from "./geometry.js";

export const VIEWS = ["joint", "torus"];

/** The geometry of its text, lengths and orientation with commas between them; null if there are not seven parts. */
export function geometryOf(text) {
  const parts = (text ?? "").split(",");
  if (parts.length !== LENGTHS.length + 1) return null;
  const lengths = LENGTHS.map((name, k) => [name, parts[k].trim()]);
  return { ...Object.fromEntries(lengths), orientation: parts.at(-1) === "cw" ? "cw" : "ccw" };
}

export function geometryText(geometry) {
  return [...LENGTHS.map((name) => geometry[name]), geometry.orientation].join(",");
}

/** The state of an address, or null if it has no geometry. */
export function stateOf(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const geometry = geometryOf(given.get("g"));
  if (!geometry) return null;
  const view = VIEWS.includes(given.get("v")) ? given.get("v") : VIEWS[0];
  return { geometry, l1: given.get("l1") ?? "1", cusp: numberOf(given.get("c")), view, at: vectorOf(given.get("p")) };
}

export function hashOf({ geometry, l1, cusp, view, at }) {
  const parts = [["g", geometryText(geometry)], ["l1", l1], ["c", letterOf(cusp)], ["v", view]];
  if (at) parts.push(["p", [at.l2, at.l3, at.pose + 1].join(",")]);
  return `#${parts.map(([name, text]) => `${name}=${encodeURIComponent(text).replaceAll("%2C", ",")}`).join("&")}`;
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

function numberOf(letters) {
  if (!/^[A-Z]{1,2}$/.test(letters ?? "")) return 0;
  return [...letters].reduce((number, letter) => 26 * number + letter.charCodeAt(0) - 64, 0) - 1;
}
