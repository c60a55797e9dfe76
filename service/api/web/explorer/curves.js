/** The singular curves of a slice, over the assembly modes or the aspects that they bound. */

import { makeLine, pixel } from "./board.js";
import { toNumber } from "./decimals.js";
import { byId, make, shape } from "./dom.js";

const MODES = [2, 4, 6];
const SHADES = 3; // that aspects of one sign have before they begin again
const COLUMNS = { joint: ["l2", "l3"], torus: ["theta1_deg", "alpha_deg"] };

export class CurveLayer {
  #view;
  #areas; // [{name, line}]
  #curve;
  #board;
  #regions = [];

  constructor(board, view) {
    this.#board = board;
    this.#view = view;
    const areas = view === "joint" ? MODES.map((count) => [`modes-${count}`, `${count} poses for each (L2, L3) in this region`]) : aspectNames();
    this.#areas = areas.map(([name, what]) => ({ name, line: makeLine(board, `area ${name}`, 1, what) }));
    this.#curve = makeLine(board, "singular", 4, "Singular curve: two poses merge");
  }

  set(document) {
    const lines = linesOf(document, this.#view);
    this.#curve.set(lines.flatMap((line) => [...(this.#view === "torus" ? wrapped(line) : line), null]));
    for (const { name, line } of this.#areas) {
      line.set(this.#outlines(document, name));
      if (this.#view === "torus" && document) line.node.dataset.what = aspectText(document, name);
    }
    this.#regions = this.#view === "joint" ? (document?.regions ?? []).filter(({ bounded }) => bounded) : [];
  }

  #outlines(document, name) {
    if (!document) return [];
    const rings =
      this.#view === "joint"
        ? document.regions.filter(({ poses, bounded }) => bounded && `modes-${poses}` === name).flatMap((region) => region.rings)
        : namedAspects(document).filter((aspect) => aspect.name === name).flatMap((aspect) => aspect.polygons);
    return rings.flatMap((ring) => [...placesOf(ring, COLUMNS[this.#view]), null]);
  }

  /** The number of poses of each region that is large enough on the screen: `[{x, y, text}]` in pixels. */
  counts() {
    const { unitX, unitY } = this.#board;
    const shown = this.#regions.filter(({ rings }) => areaOf(placesOf(rings[0], COLUMNS.joint)) * unitX * unitY > 500);
    return shown.map(({ poses, point }) => {
      const [x, y] = pixel(this.#board, [toNumber(point.l2), toNumber(point.l3)]);
      return { x, y, text: String(poses) };
    });
  }
}

/** What the shades stand for, in words: `[{name, text}]`. */
export function legendOf(document, view) {
  if (!document) return [];
  if (view === "torus") {
    return namedAspects(document).map(({ name, sign, share }) => ({
      name,
      text: `J ${sign > 0 ? ">" : "<"} 0 (${(100 * share).toPrecision(2)} %)`,
    }));
  }
  const counts = MODES.map((poses) => [poses, document.regions.filter((region) => region.bounded && region.poses === poses).length]);
  return counts
    .filter(([, regions]) => regions > 0)
    .map(([poses, regions]) => ({ name: `modes-${poses}`, text: `${poses} poses in ${regions} region${regions > 1 ? "s" : ""}` }));
}

const strandsOf = (document) => (document?.components ?? []).flatMap(({ strands }) => strands);

/** The places of each singular curve. */
export const linesOf = (document, view) => strandsOf(document).map((strand) => placesOf(strand, COLUMNS[view]));

/** The cusps and the other special points, as a cusp table has them. */
export function sliceOf(document, l1) {
  const vertices = strandsOf(document).flatMap((strand) => strand.vertices);
  const cusps = vertices.filter(({ kind }) => kind === "cusp").sort((one, other) => one.cusp - other.cusp);
  return { l1, count: cusps.length, cusps, degenerate_points: [] };
}

/** A line in continuous angles, cut where it leaves the square from −180 to 180 degrees. */
export function wrapped(places) {
  if (places.length < 2) return places.map((place) => place.map(inTurn));
  const out = [];
  places.slice(1).forEach((place, k) => {
    for (const [start, end] of cutAtSeams(places[k], place)) {
      const cell = start.map((x, axis) => 360 * Math.round((x + end[axis]) / 720)); // that of the middle: ends may lie on a seam
      const [first, last] = [start, end].map((point) => point.map((x, axis) => x - cell[axis]));
      if (!isAt(out.at(-1), first)) out.push(...(out.length > 0 ? [null, first] : [first]));
      out.push(last);
    }
  });
  return out;
}

/** The pieces of a segment between the seams at ±180°, ±540°, … of either angle. */
function cutAtSeams(from, to) {
  const shares = from.flatMap((start, axis) => {
    const [low, high] = [Math.min(start, to[axis]), Math.max(start, to[axis])];
    const seams = [];
    for (let seam = Math.ceil((low - 180) / 360) * 360 + 180; seam < high; seam += 360) {
      if (seam > low) seams.push((seam - start) / (to[axis] - start));
    }
    return seams;
  });
  const at = (share) => from.map((x, axis) => x + share * (to[axis] - x));
  const ends = [from, ...shares.sort((a, b) => a - b).map(at), to];
  return ends.slice(1).map((end, k) => [ends[k], end]);
}

const isAt = (place, other) => Boolean(place) && Math.hypot(place[0] - other[0], place[1] - other[1]) < 1e-6;

const inTurn = (degrees) => degrees - 360 * Math.round(degrees / 360);

function placesOf(samples, [x, y]) {
  return samples[x].map((value, k) => [value, samples[y][k]]);
}

function areaOf(places) {
  const twice = places.reduce((sum, [x, y], k) => {
    const [u, v] = places[(k + 1) % places.length];
    return sum + x * v - u * y;
  }, 0);
  return Math.abs(twice) / 2;
}

function aspectNames() {
  return [1, -1].flatMap((sign) => Array.from({ length: SHADES }, (_, k) => [aspectName(sign, k), ""]));
}

/** What the areas of a shade are: one aspect, or some that look the same. */
function aspectText(document, name) {
  const shown = namedAspects(document).filter((aspect) => aspect.name === name);
  const shares = shown.map(({ share }) => `${(100 * share).toPrecision(2)} %`);
  return shown.length === 0 ? "" : `Aspect, J ${shown[0].sign > 0 ? ">" : "<"} 0: ${shares.join(" or ")} of all poses, no singularity inside`;
}

function aspectName(sign, k) {
  return `${sign > 0 ? "plus" : "minus"}-${(k % SHADES) + 1}`;
}

function namedAspects({ aspects }) {
  const seen = { 1: 0, "-1": 0 };
  return aspects.map((aspect) => ({ ...aspect, name: aspectName(aspect.sign, seen[aspect.sign]++) }));
}

/** Shows the entries of a legend that are there: a sample of the named class, `as` an area, a line, a mark or a path `d`, and a text. */
export function showLegend(entries, id = "legend") {
  const shown = entries.filter((entry) => entry.if ?? true);
  const text = JSON.stringify(shown);
  if (byId(id).dataset.shown === text) return;
  byId(id).dataset.shown = text;
  byId(id).replaceChildren(...shown.map(({ name, text: words, as = "area", d }) => {
    const sample = shape("svg", { viewBox: "0 0 20 12", "aria-hidden": "true" });
    sample.append({
      area: () => shape("rect", { width: 20, height: 12, class: `area ${name}` }),
      line: () => shape("path", { d: "M0 6H20", class: name }),
      path: () => shape("path", { d, class: name }),
      mark: () => shape("circle", { cx: 10, cy: 6, r: 5, class: name }),
      cross: () => shape("path", { d: "M5 1L15 11M5 11L15 1", class: name }),
    }[as]());
    return make("li", {}, sample, words);
  }));
}
