/** The mechanism: base, legs and platform; A2, A3, B2 and B3 can be dragged. */

import { bindZoom, fit, makeBoard, makeLine, makePoint, put, zoomAbout } from "./board.js";
import { basePoints, dragged, heldDirection, measured, placeOf, placesOf, platformPoints } from "./geometry.js";

const NAMES = ["A1", "A2", "A3", "B1", "B2", "B3"];
const FREE = ["A2", "A3", "B2", "B3"];
const EDGE = 18; // pixels, for the names of points
const OFFSETS = { A1: [8, -12], A2: [8, -12], A3: [8, 10], B1: [-22, 10], B2: [8, 10], B3: [8, 10] };

export class Mechanism {
  #board = makeBoard("mechanism-board", "The manipulator");
  #lines = {
    orbit: makeLine(this.#board, "orbit", 2),
    base: makeLine(this.#board, "base", 3),
    candidate: makeLine(this.#board, "candidate", 3),
    ghosts: makeLine(this.#board, "ghost", 3),
    platform: makeLine(this.#board, "platform", 4),
    legs: makeLine(this.#board, "legs", 6),
  };
  #points = {};
  #shown = null; // {geometry, lengths, l1, b1, alpha}
  #ghosts = []; // corners of other poses
  #candidate = null; // the lengths of another geometry
  #held = null; // the point that is dragged
  #onDrag;

  /** `onDrag(geometry)` is told each geometry on the grid while a point is dragged, `onRest()` its end. */
  constructor({ onDrag, onRest }) {
    this.#onDrag = onDrag;
    for (const name of NAMES) this.#points[name] = this.#point(name);
    for (const name of FREE) {
      const point = this.#points[name];
      point.on("drag", () => this.#drag(name));
      point.on("up", () => {
        this.#held = null;
        onRest();
      });
      point.rendNode.addEventListener("blur", () => (this.#held = null));
    }
    const zoom = (factor) => zoomAbout(this.#board, this.#middle(), factor);
    bindZoom(document.getElementById("mechanism"), { zoom, showAll: () => this.showAll() });
  }

  get isHeld() {
    return this.#held !== null;
  }

  /** Draws the manipulator at a pose; while a point is dragged, the platform stays where it is. */
  draw(geometry, pose) {
    const lengths = measured(geometry);
    if (!lengths) return;
    const isFirst = !this.#shown;
    const place = this.#held && this.#shown ? this.#shown : placeOf(pose);
    this.#shown = { geometry, lengths, l1: pose.l1, b1: place.b1, alpha: place.alpha };
    this.#update();
    this.#board.containerObj.classList.remove("empty");
    if (isFirst || !this.#isInView()) this.showAll();
  }

  /** Whether the platform can be seen; while a point is dragged the view stays as it is. */
  #isInView() {
    const [left, top, right, bottom] = this.#board.getBoundingBox();
    const { lengths, b1, alpha } = this.#shown;
    const corners = [...platformPoints(lengths, b1, alpha), ...this.#ghosts.flat()];
    const edge = EDGE / this.#board.unitX;
    const isInside = ([x, y]) => left + edge < x && x < right - edge && bottom + edge < y && y < top - edge;
    return this.#held || corners.every(isInside);
  }

  /** Draws other poses as outlines. */
  drawGhosts(poses) {
    if (poses.length === 0 && this.#ghosts.length === 0) return;
    const { lengths } = this.#shown ?? {};
    this.#ghosts = lengths ? poses.map(placeOf).map(({ b1, alpha }) => platformPoints(lengths, b1, alpha)) : [];
    this.#lines.ghosts.set(this.#ghosts.flatMap((corners) => [...corners, corners[0], null]));
    this.#board.update();
    if (lengths && !this.#isInView()) this.showAll();
  }

  /** Draws the base and the platform of another geometry as outlines, at the same pose; null draws none. */
  drawCandidate(geometry) {
    this.#candidate = geometry && measured(geometry);
    if (this.#shown) this.#update();
  }

  showAll() {
    const { lengths, b1, alpha } = this.#shown ?? {};
    if (!lengths) return;
    const corners = [...platformPoints(lengths, b1, alpha), ...this.#ghosts.flat()];
    fit(this.#board, [...basePoints(lengths), ...corners, ...orbitOf(b1, 4)], { keepAspect: true });
  }

  #middle() {
    const [left, top, right, bottom] = this.#board.getBoundingBox();
    return [(left + right) / 2, (top + bottom) / 2];
  }

  #point(name) {
    const isFree = FREE.includes(name);
    const cssClass = isFree ? "handle" : "joint";
    const point = makePoint(this.#board, name, { cssClass, size: isFree ? 6 : 3, draggable: isFree, label: OFFSETS[name] });
    const { rendNode } = point;
    if (isFree) {
      rendNode.setAttribute("role", "img");
      rendNode.setAttribute("aria-label", name);
      rendNode.setAttribute("aria-roledescription", "point that the arrow keys move");
    } else {
      rendNode.setAttribute("aria-hidden", "true");
    }
    point.label.rendNode.setAttribute("aria-hidden", "true");
    return point;
  }

  #drag(name) {
    const { geometry, lengths, l1, b1, alpha } = this.#shown;
    const point = this.#points[name];
    const corners = platformPoints(lengths, b1, alpha);
    const next = dragged(geometry, name, [point.X(), point.Y()], corners, placesOf(lengths));
    if (next) {
      this.#held = name;
      const after = measured(next);
      const turned = name.startsWith("B") ? directionAfter(after, name, corners, [point.X(), point.Y()]) : alpha;
      this.#shown = { geometry: next, lengths: after, l1, b1, alpha: turned };
    }
    this.#update(); // also where the point may not go
    if (next) this.#onDrag(next);
  }

  #update() {
    const { geometry, lengths, b1, alpha } = this.#shown;
    const base = basePoints(lengths);
    const corners = platformPoints(lengths, b1, alpha);
    const other = this.#candidate;
    const outlines = other ? [basePoints(other), platformPoints(other, b1, alpha)] : [];
    this.#lines.candidate.set(outlines.flatMap((outline) => [...outline, outline[0], null]));
    this.#lines.orbit.set(orbitOf(b1, 96));
    this.#lines.base.set([...base, base[0]]);
    this.#lines.platform.set([...corners, corners[0]]);
    this.#lines.legs.set(base.flatMap((foot, k) => [foot, corners[k], null]));
    [...base, ...corners].forEach((place, k) => put(this.#points[NAMES[k]], place));
    for (const name of FREE) this.#points[name].rendNode.setAttribute("aria-label", spoken(name, geometry));
    this.#board.update();
  }
}

/** Points of the circle on which B1 moves in a slice. */
function orbitOf(b1, count) {
  const radius = Math.hypot(...b1);
  const turns = Array.from({ length: count + 1 }, (_, k) => (2 * k * Math.PI) / count);
  return turns.map((turn) => [radius * Math.cos(turn), radius * Math.sin(turn)]);
}

function directionAfter(lengths, name, corners, to) {
  const moved = [...corners];
  moved[name === "B2" ? 1 : 2] = to;
  return heldDirection(lengths, name, moved);
}

function spoken(name, { a2x, a3x, a3y, d1, d2, d3 }) {
  return {
    A2: `Base point A2, a2x = ${a2x}`,
    A3: `Base point A3, a3x = ${a3x}, a3y = ${a3y}`,
    B2: `Platform point B2, d1 = ${d1}, d2 = ${d2}`,
    B3: `Platform point B3, d2 = ${d2}, d3 = ${d3}`,
  }[name];
}
