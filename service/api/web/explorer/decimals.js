/** Decimal text: what is shown is what is sent. Floats are for pictures and for steps of a slider. */

import { ROOT } from "./surds.js";

/** The number that a decimal, a fraction such as "426/25" or a root such as "5*sqrt(3)/2" stands for; NaN for anything else. */
export function toNumber(text) {
  const root = ROOT.exec(String(text).trim());
  if (root) {
    const [factor, square, divisor] = [root[2] ?? "1", root[3], root[4] ?? "1"].map(toNumber);
    return ((root[1] === "-" ? -factor : factor) * Math.sqrt(square)) / divisor;
  }
  const parts = String(text).trim().split("/");
  if (parts.length > 2 || parts.some((part) => !/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(part.trim()))) return NaN;
  return parts.length === 1 ? Number(parts[0]) : Number(parts[0]) / Number(parts[1]);
}

/** A decimal without needless zeros, with at most so many places. */
export function decimal(value, places) {
  const text = value.toFixed(Math.min(Math.max(places, 0), 20));
  const short = text.includes(".") ? text.replace(/\.?0+$/, "") : text;
  return short === "-0" ? "0" : short;
}

/** The step of the grid for a drawing of a size: a power of ten, some thousandth of it. */
export function gridPlaces(size) {
  return 3 - Math.floor(Math.log10(size || 1));
}

/** A decimal strictly between two numbers, with as few digits as may be and near their middle; null if none is found. */
export function between(low, high) {
  const middle = (low + high) / 2;
  for (let places = 0; places <= 17; places += 1) {
    const text = decimal(middle, places);
    if (low < Number(text) && Number(text) < high) return text;
  }
  return null;
}

/** A long decimal for people: rounded to so many significant digits. */
export function shortened(text, digits = 6) {
  const value = Number(text);
  if (!Number.isFinite(value)) return String(text);
  const short = Number(value.toPrecision(digits));
  return short === 0 || (Math.abs(short) >= 1e-4 && Math.abs(short) < 1e9) ? String(short).replace("-", "−") : value.toExponential(3);
}

/** What somebody has entered, with a decimal comma as a point: 15,91 → 15.91. */
export function pointed(text) {
  return text.trim().replace(/^([+-]?\d*),(\d+)$/, "$1.$2");
}
