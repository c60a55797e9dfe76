/** The slice: its curves and cusps in the (L2, L3) plane, or on the torus of its poses (θ1, α). */

import { EXACT, ROOM, axes, namesOf, plotOf } from "./axes.js";
import { Frame, fit, makeBoard, makeLine, makePoint, move, overlay, pixel, put, zoomAbout } from "./board.js";
import { CurveLayer, linesOf, showLegend, wrapped } from "./curves.js";
import { decimal, gridPlaces, shortened, toNumber } from "./decimals.js";
import { byId, on, shape } from "./dom.js";
import { mergeNear } from "./merging.js";
import { bindPicking } from "./picking.js";
import { letterOf } from "./state.js";

const REST = 300; // ms
const ZOOM = 1.6;
const STRETCH = 1.5; // by which scales of lengths may differ, before the board is filled instead
const AXES = { joint: ["L2", "L3"], torus: ["θ1", "α"] };
const PLACES = {
  joint: (cusp) => [Number(cusp.l2), Number(cusp.l3)],
  torus: (cusp) => [Number(cusp.theta1_deg), Number(cusp.alpha_deg)],
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
  #isPath = false; // whether they are of a path other than a loop
  #limits = null; // the line of the rectangle
  #rectangle = null; // its bounds
  #poses = []; // marks of the poses of a joint vector, on the torus
  #vector = null; // the mark of the joint vector, in the plane
  #at = null; // the joint vector, in texts or numbers, with the number of the chosen pose
  #listed = []; // its poses
  #isMerged = false; // whether it was put where poses merge
  #write = null; // of what is over the board
  #isDue = false; // whether the next curves are another picture, which is to be seen whole
  #frame = null;
  #slice = null;
  #selected = 0;
  #active = 0; // the cusp that the Tab key reaches
  #told;
  #timer = null;
  isDrawing = false; // whether a drag draws joint limits

  /**
   * `onSelect(index)` and `onVisit(index)` are told which cusp was chosen or looked at, `onPick({l2, l3})` which other
   * joint vector, `onHold({l2, l3, merge})` each while it is dragged, `onPose(pose)` which pose of the torus,
   * `onLimits({l2, l3})` which rectangle, `onZoom(factor)` how much the picture is magnified.
   */
  constructor(told) {
    this.#told = told;
    const actions = { in: () => this.#zoom(ZOOM), out: () => this.#zoom(1 / ZOOM), all: () => this.#frame?.showAll() };
    for (const [name, action] of Object.entries(actions)) on(`zoom-${name}`, "click", action);
  }

  fitNext() {
    this.#isDue = true;
  }

  /** Draws a slice: its cusps over the document of its singular curves, if there is one. */
  draw(slice, curves, view, selected) {
    [this.#slice, this.#curves, this.#selected] = [slice, curves, selected];
    this.show(view);
  }

  show(view) {
    if (!this.#slice) return;
    this.#open(view);
    const { cusps = [] } = this.#slice;
    while (this.#points.length > cusps.length) this.#board.removeObject(this.#points.pop());
    while (this.#points.length < cusps.length) this.#points.push(this.#point(this.#points.length));
    cusps.forEach((cusp, k) => put(this.#points[k], PLACES[view](cusp)));
    this.#group.role = cusps.length > 0 ? "listbox" : null; // an empty list would be none
    this.#group.ariaLabel = cusps.length > 0 ? "Cusps" : null;
    this.#layer.set(this.#curves);
    this.select(this.#selected);
    if (this.#isDue) this.#frame.showAll();
    this.#isDue = false;
    this.#follow();
  }

  #follow() {
    this.#frame.follow();
    this.#repaint();
  }

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

  drawLoop(samples, isPath = false) {
    [this.#samples, this.#isPath] = [samples, isPath];
    if (!this.#board) return;
    const places = samples.map(PLACES[this.#view]);
    this.#loop.node.dataset.what = this.#isPath ? "Path without a singularity" : "Loop round the cusp, without a singularity";
    this.#loop.set(this.#view === "torus" ? wrapped(places) : places);
    this.#follow();
  }

  /** Marks the joint vector where the mechanism is or, on the torus, its poses, the chosen one filled. */
  drawPoses(at, poses) {
    [this.#at, this.#listed] = [at, poses];
    if (!this.#board) return;
    if (this.#view === "joint") this.#drawVector();
    else this.#drawMarks();
    this.#explain();
  }

  #drawVector() {
    const place = ["l2", "l3"].map((leg) => toNumber(this.#at?.[leg]));
    const isThere = place.every(Number.isFinite);
    if (this.#vector.visPropCalc.visible !== isThere) this.#vector.setAttribute({ visible: isThere });
    if (!isThere) return;
    move(this.#vector, place);
    const { rendNode } = this.#vector;
    rendNode.ariaLabel = `Joint vector, L2 = ${shortened(place[0])}, L3 = ${shortened(place[1])}`;
    rendNode.dataset.what = `${rendNode.ariaLabel}: drag it, and the poses follow`;
  }

  #drawMarks() {
    const poses = this.#listed;
    while (this.#poses.length > poses.length) this.#board.removeObject(this.#poses.pop());
    while (this.#poses.length < poses.length) {
      this.#poses.push(makePoint(this.#board, { cssClass: "pose-point", size: 5, layer: 8, what: "A pose of the joint vector" }));
      this.#poses.at(-1).rendNode.ariaHidden = true;
    }
    poses.forEach((pose, k) => {
      move(this.#poses[k], wrapped([PLACES.torus(pose)])[0]);
      this.#poses[k].rendNode.classList.toggle("chosen", k === this.#at.pose);
    });
  }

  /** The joint vector that is dragged, on the grid of decimals that pixels tell apart, or where poses merge if that is near. */
  #hold(event) {
    const { unitX, unitY } = this.#board;
    const place = [this.#vector.X(), this.#vector.Y()];
    const isLeft = event.type === "keydown" && this.#isMerged; // else an arrow key would not get away
    const near = isLeft ? null : mergeNear(this.#curves, this.#slice.cusps ?? [], place, [unitX, unitY]);
    this.#isMerged = Boolean(near);
    const [l2, l3] = place.map((length, k) => decimal(Math.max(length, 4 / [unitX, unitY][k]), gridPlaces(1000 / [unitX, unitY][k])));
    this.#told.onHold(near ?? { l2, l3, merge: null });
  }

  #picked([x, y]) {
    if (this.#view === "torus") this.#told.onPose({ theta1_deg: Number(x), alpha_deg: Number(y) });
    else if (Math.min(x, y) > 0) this.#told.onPick({ l2: x, l3: y });
  }

  drawLimits(limits) {
    this.#rectangle = limits?.l2 || limits?.l3 ? limits : null;
    if (!this.#board) return;
    this.#limits.set(this.#rectangle && this.#view === "joint" ? this.#corners() : []);
    this.#repaint();
  }

  #corners() {
    const [left, top, right, bottom] = this.#board.getBoundingBox();
    const far = 10 * Math.max(right - left, top - bottom, right, top);
    const end = (leg, name, open) => (Number.isFinite(toNumber(this.#rectangle[leg]?.[name])) ? toNumber(this.#rectangle[leg][name]) : open);
    const [x0, x1, y0, y1] = [end("l2", "min", -far), end("l2", "max", far), end("l3", "min", -far), end("l3", "max", far)];
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
  }

  #extent() {
    if (this.#view === "torus") return [[-180, -180], [180, 180]];
    const places = (this.#slice?.cusps ?? []).map(PLACES.joint);
    return [...places, ...this.#samples.map(PLACES.joint), ...linesOf(this.#curves, "joint").flat()];
  }

  #zoom(factor) {
    const point = this.#points[this.#selected];
    if (point) zoomAbout(this.#board, [point.X(), point.Y()], factor);
  }

  #openGroup(members) {
    const places = members.map((k) => [this.#points[k].X(), this.#points[k].Y()]);
    const side = (this.#board.canvasWidth - ROOM.left - ROOM.right) / 3.5;
    const tall = (this.#board.canvasHeight - ROOM.top - ROOM.bottom) / 3.5;
    const room = { left: ROOM.left + side, right: ROOM.right + side, top: ROOM.top + tall, bottom: ROOM.bottom + tall };
    fit(this.#board, places, { room, stretch: STRETCH });
    this.#points[members[0]].rendNode.focus();
  }

  #moved() {
    this.#clip(plotOf(this.#board));
    this.#repaint();
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#told.onZoom(this.#frame.factor), REST);
  }

  #open(view) {
    if (view === this.#view) return;
    this.fitNext();
    const container = byId("slice-board");
    const fresh = container.cloneNode(false); // a board leaves listeners behind on its element
    container.replaceWith(fresh);
    this.#view = view;
    this.#board = makeBoard("slice-board", view === "joint" ? "Joint space of the slice" : "Torus of its poses", true);
    [this.#points, this.#poses] = [[], []];
    bindPicking(this.#board, { ...this.#told, onPlace: (place) => this.#picked(place), isDrawing: () => this.isDrawing, onDraft: (limits) => this.drawLimits(limits) });
    this.#layer = new CurveLayer(this.#board, view);
    this.#limits = makeLine(this.#board, "limits", 3, "Joint limits of legs 2 and 3");
    this.#others = makeLine(this.#board, "degenerate", 8, "A degenerate pose, not a cusp");
    this.#loop = makeLine(this.#board, "loop", 6);
    this.#vector = view === "joint" ? this.#makeVector() : null;
    this.#group = this.#board.renderer.layer[9];
    on(this.#group, "keydown", (event) => this.#key(event), true);
    const writeAxes = overlay(this.#board, () => axes(this.#board, AXES[view], view === "torus"), () => this.#board.getBoundingBox().join());
    const writeNames = overlay(this.#board, () => this.#labels());
    this.#write = () => {
      writeAxes();
      writeNames();
    };
    const look = view === "joint" ? { room: ROOM, stretch: STRETCH } : { room: EXACT, stretch: Infinity };
    this.#frame = new Frame(this.#board, () => this.#extent(), { ...look, onMove: () => this.#moved() });
    this.drawLoop(this.#samples, this.#isPath);
    this.drawLimits(this.#rectangle);
    this.drawPoses(this.#at, this.#listed);
  }

  #makeVector() {
    const vector = makePoint(this.#board, { cssClass: "vector", size: 6, layer: 8, draggable: true });
    const { rendNode } = vector;
    rendNode.role = "img";
    rendNode.ariaRoleDescription = "point that the arrow keys move";
    rendNode.dataset.vector = "";
    vector.on("drag", (event) => this.#hold(event));
    return vector;
  }

  #labels() {
    const plot = plotOf(this.#board);
    const isIn = ({ x, y }) => x > plot.left && x < plot.right && y > plot.top && y < plot.bottom;
    const spots = this.#points.map((point, k) => {
      const [x, y] = pixel(this.#board, [point.X(), point.Y()]);
      return { x, y, k };
    }).filter(isIn);
    const names = namesOf(spots, spots.map(({ k }) => letterOf(k)), plot);
    const boxes = names.map(({ at: [x, y] }) => ({ x, y }));
    const counts = this.#layer.counts().filter((count) => isIn(count) && [...boxes, ...spots].every(({ x, y }) => Math.hypot(x - count.x, y - count.y) > 16));
    return [
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
    on(group, "click", (event) => {
      event.stopPropagation();
      this.#openGroup(members);
    });
    on(group, "keydown", (event) => ["Enter", " "].includes(event.key) && this.#openGroup(members));
    return group;
  }

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

  #explain() {
    const isJoint = this.#view === "joint";
    showLegend([
      { name: "singular", as: "line", text: "singular curve", if: Boolean(this.#curves) },
      { name: "cusp", as: "mark", text: "cusp", if: this.#points.length > 0 },
      { name: "degenerate", as: "cross", text: "degenerate, no cusp", if: this.#slice?.degenerate_points?.length > 0 },
      { name: "loop", as: "line", text: this.#isPath ? "path without a singularity" : "loop round the cusp", if: this.#samples.length > 0 },
      { name: isJoint ? "vector" : "pose-point chosen", as: "mark", text: isJoint ? "joint vector" : "its poses", if: Boolean(this.#at) },
      { name: "limits", as: "area", text: "joint limits", if: isJoint && Boolean(this.#rectangle) },
    ], "marks");
  }

  #point(index) {
    const point = makePoint(this.#board, { cssClass: "cusp", size: 5 });
    const node = point.rendNode;
    node.role = "option";
    node.dataset.cusp = index;
    on(node, "click", () => !this.isDrawing && this.#told.onSelect(index));
    on(node, "focus", () => this.#told.onVisit(index));
    on(node, "pointerenter", () => this.#told.onVisit(index));
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
      rendNode.tabIndex = k === this.#active ? 0 : -1;
      rendNode.ariaSelected = k === this.#selected;
      rendNode.ariaLabel = rendNode.dataset.what = what;
      rendNode.classList.toggle("selected", k === this.#selected);
    });
  }
}

function crossAt(board, [x, y]) {
  const [dx, dy] = [6 / board.unitX, 6 / board.unitY];
  return Number.isFinite(x + y) ? [[x - dx, y - dy], [x + dx, y + dy], null, [x - dx, y + dy], [x + dx, y - dy], null] : [];
}

export function spoken(cusp, index) {
  const { l2, l3, alpha_deg: alpha, theta1_deg: theta } = cusp;
  const angles = `α = ${shortened(alpha)}°, θ1 = ${shortened(theta)}°`;
  return `Cusp ${letterOf(index)}: L2 = ${shortened(l2)}, L3 = ${shortened(l3)}, ${angles}`;
}
