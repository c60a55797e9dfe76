/**
 * Triangles from one spelling to another, exactly: a number q·√r is its sign and its square, a quotient of whole
 * numbers. What is shown is then the same manipulator, and the service answers from what it has.
 */

const DECIMAL = /^([+-]?)(\d+\.?\d*|\.\d+)(?:e([+-]?\d{1,3}))?$/i;
export const ROOT = /^([+-]?)(?:([^*()]+)\*)?sqrt\(([^()]+)\)(?:\/([^()/]+))?$/;

const ZERO = [0n, 1n];
const gcd = (a, b) => (b ? gcd(b, a % b) : a < 0n ? -a : a);

function quotient(n, d) {
  const by = gcd(n, d) * (d < 0n ? -1n : 1n);
  return [n / by, d / by];
}

const plus = ([a, b], [c, d]) => quotient(a * d + c * b, b * d);
const times = ([a, b], [c, d]) => quotient(a * c, b * d);
const over = (x, [c, d]) => times(x, [d, c]);
const minus = (x, [c, d]) => plus(x, [-c, d]);

/** The number of a decimal or of a quotient of two; null for anything else. */
function rational(text) {
  const [top, bottom = "1", more] = text.trim().split("/").map((part) => part.trim());
  const [x, y] = [decimalOf(top), decimalOf(bottom)];
  return x && y?.[0] && more === undefined ? over(x, y) : null;
}

function decimalOf(text) {
  const parts = DECIMAL.exec(text);
  if (!parts) return null;
  const [whole, fraction = ""] = parts[2].split(".");
  const places = fraction.length - Number(parts[3] ?? 0);
  const digits = BigInt(`${parts[1] === "-" ? "-" : ""}${whole}${fraction}`);
  return places > 0 ? quotient(digits, 10n ** BigInt(places)) : [digits * 10n ** BigInt(-places), 1n];
}

/** The sign and the square of a number such as 17.04, 426/25 or 5*sqrt(3)/2; null for anything else. */
function surd(text) {
  const parts = ROOT.exec(text.trim());
  const factors = parts ? [parts[2] ?? "1", parts[3], parts[4] ?? "1"].map(rational) : [rational(text), [1n, 1n], [1n, 1n]];
  if (factors.includes(null) || factors[1][0] < 0n || !factors[2][0]) return null;
  const [factor, square, divisor] = factors;
  const value = over(factor, divisor);
  const isNegative = (value[0] < 0n) !== (parts?.[1] === "-");
  return { sign: isNegative ? -1 : 1, square: times(times(value, value), square) };
}

/** The root of a whole number that is a square; else null. */
function rootOf(n) {
  let root = n;
  for (let next = (n + 1n) / 2n; next < root; next = (root + n / root) / 2n) root = next;
  return root * root === n ? root : null;
}

/** The root of a quotient that is a square; else null. */
function exactRoot([n, d]) {
  const [top, bottom] = [rootOf(n), rootOf(d)];
  return top === null || bottom === null ? null : [top, bottom];
}

/** A quotient as people write it: a decimal if it is one. */
function textOf([n, d]) {
  for (let places = 0; places <= 40; places += 1) {
    const scaled = n * 10n ** BigInt(places);
    if (scaled % d) continue;
    const digits = String(scaled < 0n ? -scaled / d : scaled / d).padStart(places + 1, "0");
    return `${n < 0n ? "-" : ""}${digits.slice(0, digits.length - places)}${places ? "." : ""}${digits.slice(digits.length - places)}`;
  }
  return `${n}/${d}`;
}

/** The root of a square, of a sign. */
function rootText(square, sign = 1) {
  const root = exactRoot(square);
  return `${sign < 0 && square[0] ? "-" : ""}${root ? textOf(root) : `sqrt(${textOf(square)})`}`;
}

/** The square of the distance of two points; null if it is irrational. */
function apart(p, q) {
  let whole = ZERO;
  for (const [k, x] of p.entries()) {
    const product = exactRoot(times(x.square, q[k].square));
    if (!product) return null;
    const twice = times(product, [2n * BigInt(x.sign * q[k].sign), 1n]);
    whole = plus(whole, minus(plus(x.square, q[k].square), twice));
  }
  return whole;
}

/** The squares of the sides of a triangle in any spelling; null if they are not found. */
function squaresOf({ points, sides, equilateral, circumradius }) {
  const [corners, lengths] = [points?.map((point) => point.map(surd)), (sides ?? [equilateral ?? circumradius ?? ""]).map(surd)];
  if (corners) return corners.flat().includes(null) ? null : [[0, 1], [1, 2], [2, 0]].map(([i, k]) => apart(corners[i], corners[k]));
  if (lengths.includes(null)) return null;
  const squares = lengths.map(({ square }) => (circumradius ? times(square, [3n, 1n]) : square));
  return sides ? squares : Array(3).fill(squares[0]);
}

/** A triangle by "points", "sides", "equilateral" or "circumradius"; null if no exact one is found. Clockwise for −1. */
export function respelledExactly(triangle, form, sense) {
  const squares = squaresOf(triangle);
  if (!squares || squares.includes(null) || squares.some(([n]) => n <= 0n)) return null;
  const [a, b, c] = squares;
  if (form === "sides") return { sides: squares.map((square) => rootText(square)) };
  if (form === "equilateral") return { equilateral: rootText(a) };
  if (form === "circumradius") return { circumradius: rootText(over(a, [3n, 1n])) };
  // corner 3 is ((a + c − b) / 2√a, √H / 2√a), H being 4 a c − (a + c − b)²
  const [along, four] = [minus(plus(a, c), b), times([4n, 1n], a)];
  const height = minus(times(four, c), times(along, along));
  if (height[0] < 0n) return null;
  const x = rootText(over(times(along, along), four), along[0] < 0n ? -1 : 1);
  return { points: [["0", "0"], [rootText(a), "0"], [x, rootText(over(height, four), sense)]] };
}
