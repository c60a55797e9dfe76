/** The slice: its curves and cusps in the (L2, L3) plane, or on the torus of its poses (α, θ1). */

import { ROOM_FOR_AXES, bindZoom, fit, makeBoard, makeLine, makePoint, put, zoomAbout } from "./board.js";
import { CurveLayer, wrapped } from "./curves.js";
import { decimal, gridPlaces, shortened, toNumber } from "./decimals.js";
import { letterOf } from "./state.js";

const REST = 300; // ms
const STILL = 4; // pixels that a click may move
const AXES = { joint: ["L2", "L3"], torus: ["α [deg]", "θ1 [deg]"] };
const PLACES = {
  joint: (cusp) => [Number(cusp.l2), Number(cusp.l3)],
  torus: (cusp) => [Number(cusp.alpha_deg), Number(cusp.theta1_deg)],
};
const ON_LOOP = {
  joint: ({ l2, l3 }) => [l2, l3],
  torus: ({ alpha, theta1 }) => [alpha, theta1],
};

export class JointSpace {
  #view = null;
  #board = null;
  #group = null; // of the cusps
  #points = [];
  #layer = null;
  #curves = null;
  #others = null; // points that are no cusps
  #loop = null;
  #here = null;
  #poses = []; // marks of a joint vector, or of its poses
  #unfitted = 0;
  #slice = null;
  #selected = 0;
  #active = 0; // the cusp that the Tab key reaches
  #onSelect;
  #onVisit;
  #onZoom;
  #onPick;
  #timer = null;
  #whole = 1; // what is seen of the first axis if all is shown

  /**
   * `onSelect(index)` is told which cusp was chosen, `onVisit(index)` which one is looked at,
   * `onPick({l2, l3})` which other place of the joint space, and `onZoom(factor)` how much the picture is magnified.
   */
  constructor({ onSelect, onVisit, onPick, onZoom }) {
    this.#onZoom = onZoom;
    this.#onPick = onPick;
    this.#onSelect = onSelect;
    this.#onVisit = onVisit;
    const zoom = (factor) => this.#zoom(factor);
    bindZoom(document.getElementById("slice-zoom"), { zoom, showAll: () => this.showAll() });
  }

  /** Shows all of what is drawn next: cusps and curves. */
  fitNext() {
    this.#unfitted = 2;
  }

  /** Draws the cusps of a slice in a view. */
  draw(slice, view, selected) {
    this.#open(view);
    this.#slice = slice;
    const cusps = slice?.cusps ?? [];
    while (this.#points.length > cusps.length) this.#board.removeObject(this.#points.pop());
    while (this.#points.length < cusps.length) this.#points.push(this.#point(this.#points.length));
    cusps.forEach((cusp, k) => put(this.#points[k], PLACES[view](cusp)));
    this.#name(cusps.length > 0);
    this.select(selected);
    this.#finish();
  }

  /** Draws a document of the singular curves under the cusps, or none. */
  drawCurves(curves, view) {
    this.#open(view);
    this.#curves = curves;
    this.#layer.set(curves);
    this.#finish();
  }

  /** Names the group of cusps; an empty list would be none. */
  #name(isList) {
    for (const [attribute, value] of [["role", "listbox"], ["aria-label", "Cusps"]]) {
      if (isList) this.#group.setAttribute(attribute, value);
      else this.#group.removeAttribute(attribute);
    }
  }

  #finish() {
    if (this.#unfitted > 0) this.showAll();
    this.#unfitted -= 1;
    this.#crossOthers();
    this.#board.update();
  }

  /** Crosses the points that are no cusps; the strokes depend on the size of a pixel. */
  #crossOthers() {
    const places = (this.#slice?.degenerate_points ?? []).map(PLACES[this.#view]);
    this.#others.set(places.flatMap((place) => crossAt(this.#board, place)));
  }

  select(index) {
    const hadFocus = this.#points.some((point) => point.rendNode === document.activeElement);
    this.#selected = index;
    this.#active = Math.min(index, Math.max(this.#points.length - 1, 0));
    this.#describe();
    if (hadFocus) this.#points[this.#active]?.rendNode.focus();
  }

  /** Draws a loop, by its samples in floats; none if they are empty. */
  drawLoop(samples) {
    const places = samples.map(ON_LOOP[this.#view]);
    this.#loop.set(this.#view === "torus" ? wrapped(places) : places);
    this.#here.setAttribute({ visible: false });
    this.#board.update();
  }

  /** Marks the place on the loop where the manipulator is. */
  mark(sample) {
    const place = ON_LOOP[this.#view](sample);
    put(this.#here, this.#view === "torus" ? wrapped([place])[0] : place);
    this.#here.setAttribute({ visible: true });
    this.#board.update();
  }

  /** Marks a joint vector or, on the torus, its poses, the chosen one filled; nothing without a vector. */
  drawPoses(at, poses) {
    const places = this.#view === "joint" ? [[toNumber(at?.l2), toNumber(at?.l3)]] : poses.map(PLACES.torus);
    const marks = at ? places.map((place, k) => ({ place, isChosen: places.length === 1 || k === at.pose })) : [];
    while (this.#poses.length > marks.length) this.#board.removeObject(this.#poses.pop());
    while (this.#poses.length < marks.length) {
      this.#poses.push(makePoint(this.#board, "", { cssClass: "pose-point", size: 5, layer: 8 }));
      this.#poses.at(-1).rendNode.setAttribute("aria-hidden", "true");
    }
    marks.forEach(({ place, isChosen }, k) => {
      put(this.#poses[k], place);
      this.#poses[k].rendNode.classList.toggle("chosen", isChosen);
    });
    this.#board.update();
  }

  showAll() {
    if (!this.#board) return;
    const places = (this.#slice?.cusps ?? []).map(PLACES[this.#view]);
    const isTorus = this.#view === "torus";
    const others = isTorus ? [[-180, -180], [180, 180]] : CurveLayer.placesOf(this.#curves, this.#view);
    fit(this.#board, [...places, ...others], { room: ROOM_FOR_AXES });
    this.#whole = this.#board.canvasWidth / this.#board.unitX;
    this.#layer.set(this.#curves);
  }

  /** Magnifies about the selected cusp. */
  #zoom(factor) {
    const point = this.#points[this.#selected];
    if (point) zoomAbout(this.#board, [point.X(), point.Y()], factor);
  }

  /** Tells how much the picture is magnified, once it has come to rest. */
  #magnified() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.#layer.set(this.#curves); // its labels depend on the size
      this.#crossOthers();
      this.#board.update();
      this.#onZoom((this.#whole * this.#board.unitX) / this.#board.canvasWidth);
    }, REST);
  }

  #open(view) {
    if (view === this.#view) return;
    this.fitNext();
    const container = document.getElementById("slice-board");
    const fresh = container.cloneNode(false); // a board leaves listeners behind on its element
    container.replaceWith(fresh);
    this.#view = view;
    this.#board = makeBoard("slice-board", view === "joint" ? "Joint space of the slice" : "Torus of its poses", AXES[view]);
    [this.#points, this.#poses] = [[], []];
    if (view === "joint") this.#bindPicking(fresh);
    this.#board.on("boundingbox", () => this.#magnified());
    this.#layer = new CurveLayer(this.#board, view);
    this.#layer.set(this.#curves);
    this.#others = makeLine(this.#board, "degenerate", 8);
    this.#loop = makeLine(this.#board, "loop", 6);
    this.#here = makePoint(this.#board, "", { cssClass: "here-point", size: 5, layer: 8 });
    this.#here.setAttribute({ visible: false });
    this.#here.rendNode.setAttribute("aria-hidden", "true");
    this.#group = this.#board.renderer.layer[9];
    this.#group.addEventListener("keydown", (event) => this.#key(event), true);
  }

  /** Takes a click beside the cusps as a joint vector, on the grid of decimals that pixels tell apart. */
  #bindPicking(container) {
    let start = null;
    container.classList.add("picks");
    container.addEventListener("pointerdown", ({ clientX, clientY }) => (start = [clientX, clientY]), true);
    container.addEventListener("click", (event) => {
      const isStill = start && Math.hypot(event.clientX - start[0], event.clientY - start[1]) < STILL;
      if (!isStill || event.target.closest("[data-cusp]")) return;
      const { unitX, unitY } = this.#board;
      const place = this.#board.getUsrCoordsOfMouse(event);
      const [l2, l3] = place.map((x, k) => decimal(x, gridPlaces(1000 / [unitX, unitY][k])));
      if (Math.min(l2, l3) > 0) this.#onPick({ l2, l3 });
    });
  }

  #point(index) {
    const point = makePoint(this.#board, letterOf(index), { cssClass: "cusp", size: 5, label: [9, 9] });
    const node = point.rendNode;
    node.setAttribute("role", "option");
    node.dataset.cusp = index;
    point.label.rendNode.setAttribute("aria-hidden", "true");
    node.addEventListener("click", () => this.#onSelect(index));
    node.addEventListener("focus", () => this.#onVisit(index));
    node.addEventListener("pointerenter", () => this.#onVisit(index));
    return point;
  }

  #key(event) {
    const count = this.#points.length;
    const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
    const targets = { Home: 0, End: count - 1 };
    if (event.shiftKey || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key in steps || event.key in targets) {
      this.#active = event.key in steps ? (this.#active + steps[event.key] + count) % count : targets[event.key];
      this.#describe();
      this.#points[this.#active].rendNode.focus();
    } else if (event.key === "Enter" || event.key === " ") {
      this.#onSelect(this.#active);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  #describe() {
    const cusps = this.#slice?.cusps ?? [];
    this.#points.forEach(({ rendNode }, k) => {
      rendNode.setAttribute("tabindex", k === this.#active ? "0" : "-1");
      rendNode.setAttribute("aria-selected", String(k === this.#selected));
      rendNode.setAttribute("aria-label", spoken(cusps[k], k));
      rendNode.classList.toggle("selected", k === this.#selected);
    });
  }
}

/** The strokes of a small cross; none for a point that is not isolated. */
function crossAt(board, [x, y]) {
  const [dx, dy] = [6 / board.unitX, 6 / board.unitY];
  return Number.isFinite(x + y) ? [[x - dx, y - dy], [x + dx, y + dy], null, [x - dx, y + dy], [x + dx, y - dy], null] : [];
}

export function spoken(cusp, index) {
  const { l2, l3, alpha_deg: alpha, theta1_deg: theta } = cusp;
  const angles = `α = ${shortened(alpha)}°, θ1 = ${shortened(theta)}°`;
  return `Cusp ${letterOf(index)}: L2 = ${shortened(l2)}, L3 = ${shortened(l3)}, ${angles}`;
}
