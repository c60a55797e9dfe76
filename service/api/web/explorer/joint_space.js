/** The slice: its curves and cusps in the (L2, L3) plane, or on the torus of its poses (θ1, α). */

import { EXACT, ROOM, axes, namesOf, plotOf } from "./axes.js";
import { bindSize, bindZoom, fit, isAmiss, makeBoard, makeLine, makePoint, overlay, pixel, put, shape, zoomAbout } from "./board.js";
import { CurveLayer, showLegend, wrapped } from "./curves.js";
import { decimal, gridPlaces, shortened, toNumber } from "./decimals.js";
import { letterOf } from "./state.js";

const REST = 300; // ms
const STRETCH = 1.5; // by which scales of lengths may differ, before the board is filled instead
const STILL = 4; // pixels that a click may move
const AXES = { joint: ["L2", "L3"], torus: ["θ1", "α"] };
const PLACES = {
  joint: (cusp) => [Number(cusp.l2), Number(cusp.l3)],
  torus: (cusp) => [Number(cusp.theta1_deg), Number(cusp.alpha_deg)],
};
const ON_LOOP = {
  joint: ({ l2, l3 }) => [l2, l3],
  torus: ({ alpha, theta1 }) => [theta1, alpha],
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
  #samples = [];
  #here = null;
  #limits = null; // the line of the rectangle
  #rectangle = null; // its bounds
  #poses = []; // marks of a joint vector, or of its poses
  #write = null; // of what is over the board
  #isDue = false; // whether the next curves are another picture, which is to be seen whole
  #isFree = false; // whether somebody has chosen what is seen
  #isFitting = false;
  #slice = null;
  #selected = 0;
  #active = 0; // the cusp that the Tab key reaches
  #told;
  #timer = null;
  #whole = 1; // what is seen of the first axis if all is shown
  isDrawing = false; // whether a drag draws joint limits

  /**
   * `onSelect(index)` is told which cusp was chosen, `onVisit(index)` which one is looked at,
   * `onPick({l2, l3})` which other place of the joint space, `onLimits({l2, l3})` which rectangle,
   * and `onZoom(factor)` how much the picture is magnified.
   */
  constructor(told) {
    this.#told = told;
    const zoom = (factor) => this.#zoom(factor);
    bindZoom(document.getElementById("slice-zoom"), { zoom, showAll: () => this.showAll() });
  }

  /** Shows all of what is drawn next. */
  fitNext() {
    this.#isFree = false;
    this.#isDue = true;
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
    if (this.#isDue) this.showAll();
    this.#isDue = false;
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
    if (!this.#isFree && isAmiss(this.#board, this.#extent(), ROOM)) this.showAll();
    this.#repaint();
  }

  /** Draws again what depends on the size of a pixel. */
  #repaint() {
    const places = (this.#slice?.degenerate_points ?? []).map(PLACES[this.#view]);
    this.#others.set(places.flatMap((place) => crossAt(this.#board, place)));
    this.#board.update();
    this.#write();
    this.#explain();
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
    this.#samples = samples;
    const places = samples.map(ON_LOOP[this.#view]);
    this.#loop.set(this.#view === "torus" ? wrapped(places) : places);
    this.#here.setAttribute({ visible: false });
    this.#finish();
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
      const what = this.#view === "joint" ? "The joint vector whose poses are listed" : "A pose of the joint vector";
      this.#poses.push(makePoint(this.#board, { cssClass: "pose-point", size: 5, layer: 8, what }));
      this.#poses.at(-1).rendNode.setAttribute("aria-hidden", "true");
    }
    marks.forEach(({ place, isChosen }, k) => {
      put(this.#poses[k], place);
      this.#poses[k].rendNode.classList.toggle("chosen", isChosen);
    });
    this.#repaint();
  }

  /** Draws joint limits, `{l2: {min, max}, l3}` as texts, any of which may be missing; null draws none. */
  drawLimits(limits) {
    this.#rectangle = limits;
    if (!this.#board) return;
    this.#limits.set(limits && this.#view === "joint" ? this.#corners() : []);
    this.#repaint();
  }

  /** The corners of the limits; an open side lies far outside. */
  #corners() {
    const [left, top, right, bottom] = this.#board.getBoundingBox();
    const far = 10 * Math.max(right - left, top - bottom, right, top);
    const end = (leg, name, open) => (Number.isFinite(toNumber(this.#rectangle[leg]?.[name])) ? toNumber(this.#rectangle[leg][name]) : open);
    const [x0, x1, y0, y1] = [end("l2", "min", -far), end("l2", "max", far), end("l3", "min", -far), end("l3", "max", far)];
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
  }

  /** What the frame shows: curves, cusps and the loop. */
  #extent() {
    if (this.#view === "torus") return [[-180, -180], [180, 180]];
    const places = (this.#slice?.cusps ?? []).map(PLACES.joint);
    return [...places, ...this.#samples.map(ON_LOOP.joint), ...CurveLayer.placesOf(this.#curves, "joint")];
  }

  showAll() {
    if (!this.#board) return;
    this.#isFitting = true;
    if (this.#view === "torus") fit(this.#board, this.#extent(), { room: EXACT, stretch: Infinity });
    else fit(this.#board, this.#extent(), { room: ROOM, stretch: STRETCH });
    this.#isFitting = this.#isFree = false;
    this.#whole = this.#board.canvasWidth / this.#board.unitX;
    this.#repaint();
  }

  /** Magnifies about the selected cusp. */
  #zoom(factor) {
    const point = this.#points[this.#selected];
    if (point) zoomAbout(this.#board, [point.X(), point.Y()], factor);
  }

  /** Magnifies a group of cusps until they part. */
  #openGroup(members) {
    const places = members.map((k) => [this.#points[k].X(), this.#points[k].Y()]);
    const side = (this.#board.canvasWidth - ROOM.left - ROOM.right) / 3.5;
    const tall = (this.#board.canvasHeight - ROOM.top - ROOM.bottom) / 3.5;
    const room = { left: ROOM.left + side, right: ROOM.right + side, top: ROOM.top + tall, bottom: ROOM.bottom + tall };
    fit(this.#board, places, { room, stretch: STRETCH });
    this.#points[members[0]].rendNode.focus();
  }

  /** Tells how much the picture is magnified, once it has come to rest. */
  #magnified() {
    this.#isFree ||= !this.#isFitting;
    this.#repaint();
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#told.onZoom((this.#whole * this.#board.unitX) / this.#board.canvasWidth), REST);
  }

  #open(view) {
    if (view === this.#view) return;
    this.fitNext();
    const container = document.getElementById("slice-board");
    const fresh = container.cloneNode(false); // a board leaves listeners behind on its element
    container.replaceWith(fresh);
    this.#view = view;
    this.#board = makeBoard("slice-board", view === "joint" ? "Joint space of the slice" : "Torus of its poses", true);
    [this.#points, this.#poses] = [[], []];
    fresh.classList.toggle("picks", view === "joint");
    if (view === "joint") this.#bindPicking(fresh);
    this.#layer = new CurveLayer(this.#board, view);
    this.#layer.set(this.#curves);
    this.#limits = makeLine(this.#board, "limits", 3, "Joint limits of legs 2 and 3");
    this.#others = makeLine(this.#board, "degenerate", 8, "A degenerate pose that is no cusp");
    this.#loop = makeLine(this.#board, "loop", 6, "Loop round the cusp, without a singularity");
    this.#here = makePoint(this.#board, { cssClass: "here-point", size: 5, layer: 8, what: "Where the mechanism is on the loop" });
    this.#here.setAttribute({ visible: false });
    this.#here.rendNode.setAttribute("aria-hidden", "true");
    this.#group = this.#board.renderer.layer[9];
    this.#group.addEventListener("keydown", (event) => this.#key(event), true);
    this.#write = overlay(this.#board, () => this.#labels());
    this.#board.on("boundingbox", () => this.#magnified());
    bindSize(this.#board, () => this.showAll());
    this.drawLimits(this.#rectangle);
  }

  /** The frame, the numbers of poses, and the names of the cusps or of groups of them. */
  #labels() {
    const plot = plotOf(this.#board);
    this.#clip(plot);
    const isIn = ({ x, y }) => x > plot.left && x < plot.right && y > plot.top && y < plot.bottom;
    const spots = this.#points.map((point, k) => {
      const [x, y] = pixel(this.#board, [point.X(), point.Y()]);
      return { x, y, k };
    }).filter(isIn);
    const names = namesOf(spots, spots.map(({ k }) => letterOf(k)), plot);
    const boxes = names.map(({ at: [x, y] }) => ({ x, y }));
    const counts = this.#layer.counts().filter((count) => isIn(count) && [...boxes, ...spots].every(({ x, y }) => Math.hypot(x - count.x, y - count.y) > 16));
    return [
      ...axes(this.#board, AXES[this.#view], this.#view === "torus"),
      ...counts.map(({ x, y, text }) => shape("text", { class: "modes", x, y: y + 4, "text-anchor": "middle" }, text)),
      ...names.map((name) => this.#nameOf({ ...name, members: name.members.map((k) => spots[k].k) })),
    ];
  }

  #nameOf({ members, text, at: [x, y], x: cx, y: cy, radius = 0 }) {
    const label = shape("text", { class: "name halo", x, y: y + 4.5, "text-anchor": "middle", "aria-hidden": "true" }, text);
    if (members.length === 1) return label;
    const what = `Zoom in on cusps ${members.map(letterOf).join(", ")}`;
    const group = shape("g", { class: "group", role: "button", tabindex: 0, "aria-label": what, "data-what": what });
    const circle = shape("circle", { cx, cy, r: radius + 9 });
    circle.style.pointerEvents = "none"; // its cusps can be clicked
    group.append(circle, label);
    group.addEventListener("click", (event) => {
      event.stopPropagation();
      this.#openGroup(members);
    });
    group.addEventListener("keydown", (event) => ["Enter", " "].includes(event.key) && this.#openGroup(members));
    return group;
  }

  /** Keeps what is drawn within the frame. */
  #clip({ left, right, top, bottom }) {
    const { svgRoot, layer } = this.#board.renderer;
    let clip = svgRoot.querySelector("#plot");
    if (!clip) {
      clip = shape("clipPath", { id: "plot" });
      clip.append(shape("rect"));
      svgRoot.append(clip);
      for (const group of layer.slice(0, 10)) group.setAttribute("clip-path", "url(#plot)");
    }
    const sides = { x: left, y: top, width: Math.max(right - left, 0), height: Math.max(bottom - top, 0) };
    for (const [name, value] of Object.entries(sides)) clip.firstChild.setAttribute(name, value);
  }

  /** The legend of lines and marks: of those that are there. */
  #explain() {
    const entries = [
      { name: "singular", as: "line", text: "singular curve", if: this.#curves },
      { name: "cusp", as: "mark", text: "cusp", if: this.#points.length },
      { name: "degenerate", as: "cross", text: "degenerate, no cusp", if: this.#slice?.degenerate_points?.length },
      { name: "loop", as: "line", text: "loop round the cusp", if: this.#samples.length },
      { name: "pose-point chosen", as: "mark", text: this.#view === "joint" ? "joint vector" : "its poses", if: this.#poses.length },
      { name: "limits", as: "area", text: "joint limits", if: this.#rectangle && this.#view === "joint" },
    ].filter((entry) => entry.if);
    const text = JSON.stringify(entries.map((entry) => entry.text));
    if (text === this.#explained) return;
    this.#explained = text;
    showLegend(entries, "marks");
  }

  #explained = "";

  /**
   * Takes a click beside the cusps as a joint vector, on the grid of decimals that pixels tell apart;
   * or a drag as joint limits.
   */
  #bindPicking(container) {
    let start = null;
    const place = (event) => {
      const { unitX, unitY } = this.#board;
      return this.#board.getUsrCoordsOfMouse(event).map((x, k) => decimal(x, gridPlaces(1000 / [unitX, unitY][k])));
    };
    const rectangle = (event) => {
      const ends = [place(start), place(event)];
      const side = (k) => {
        const [min, max] = ends.map((end) => Math.max(Number(end[k]), 0)).sort((a, b) => a - b);
        return { min: String(min), max: String(max) };
      };
      return { l2: side(0), l3: side(1) };
    };
    container.addEventListener("pointerdown", (event) => {
      start = event;
      if (!this.isDrawing) return;
      event.stopImmediatePropagation(); // else the picture would move along
      container.setPointerCapture(event.pointerId);
    }, true);
    container.addEventListener("pointermove", (event) => {
      if (this.isDrawing && event.buttons && start) this.drawLimits(rectangle(event));
    });
    container.addEventListener("click", (event) => {
      const isStill = start && Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) < STILL;
      if (this.isDrawing && start && !isStill) return this.#told.onLimits(rectangle(event));
      if (!isStill || event.target.closest("[data-cusp]")) return;
      const [l2, l3] = place(event);
      if (Math.min(l2, l3) > 0) this.#told.onPick({ l2, l3 });
    });
  }

  #point(index) {
    const point = makePoint(this.#board, { cssClass: "cusp", size: 5 });
    const node = point.rendNode;
    node.setAttribute("role", "option");
    node.dataset.cusp = index;
    node.addEventListener("click", () => !this.isDrawing && this.#told.onSelect(index));
    node.addEventListener("focus", () => this.#told.onVisit(index));
    node.addEventListener("pointerenter", () => this.#told.onVisit(index));
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
      this.#told.onSelect(this.#active);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  #describe() {
    const cusps = this.#slice?.cusps ?? [];
    this.#points.forEach(({ rendNode }, k) => {
      const what = spoken(cusps[k], k);
      rendNode.setAttribute("tabindex", k === this.#active ? "0" : "-1");
      rendNode.setAttribute("aria-selected", String(k === this.#selected));
      rendNode.setAttribute("aria-label", what);
      rendNode.dataset.what = what;
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
