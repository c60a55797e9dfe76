/**
 * The joint space in three dimensions: the singular surface with its edges, the cusp curves; the plane of a slice with its
 * curves; the loop round a cusp; and joint limits. It is turned and magnified by pointer, fingers and keys.
 */

import { namesOf, ticksOf } from "../explorer/axes.js";
import { symbol } from "../explorer/board.js";
import { showLegend } from "../explorer/curves.js";
import { between, shortened, toNumber } from "../explorer/decimals.js";
import { make, on, shape, write } from "../explorer/dom.js";
import { basePoints, measured, platformPoints } from "../explorer/geometry.js";
import { WHILE_MOVING, pictureOf } from "../explorer/questions.js";
import { geometryText, letterOf } from "../explorer/state.js";
import { Camera } from "./camera.js";
import { CanvasDrawing } from "./canvas.js";
import { edgeAt, edgeNear } from "./edge_picking.js";
import { frameOf } from "./frame.js";
import { GRID } from "./surface.js";
import { bindTurning } from "./turning.js";
import { WebGlDrawing } from "./webgl.js";
import { Work } from "./work.js";

const COARSE = [32, 32, 24]; // the grid of the first picture, and while something moves
const REST = 300; // ms without a change after which something rests
const BEYOND = 1.15; // times the last transition, up to which lengths are shown
const GUESS = 1.7; // times the longest side, while transitions are not known
const OTHER = 0.03; // the share by which a reach must differ to be another one
const STEPS = 500; // of the slider of another leg
const NEAR = 0.01; // of the box, within which a cusp is on an edge
const CONTOURS = 9; // of the surface
const ALPHAS = { light: [0.3, 0.72], dark: [0.34, 0.7] };
const [WHOLE, LEAST] = [340, 0.65]; // pixels of a picture whose lines are as bold as can be; and how bold they are at least
const LOW = 0.25; // times the greatest length of a leg: shortest ones below it begin at 0
const SCALE = 2; // pixels of a saved picture by one of the page
const [CUSP, EVENT, HERE] = [9, 11, 14]; // sizes of marks in pixels
const FORMS = { ring: 0, swallowtail: 1, lips: 2, "beak-to-beak": 3, dot: 4 };
const SHAPES = { swallowtail: "M10 0L17 6L10 12L3 6Z", lips: "M5 1H15V11H5Z", "beak-to-beak": "M4 11H16L10 1Z" };
const COLOURS = ["card", "ink", "line", "cusp", "loop", "accent", "two", "four", "six", "more", "fewer"];
const dark = matchMedia("(prefers-color-scheme: dark)");

export class Space {
  #told;
  #camera = new Camera();
  #work = new Work();
  #webGl = null;
  #flat = null; // what draws where there is no WebGL
  #isLost = false;
  #shown = {};
  #nodes = {};
  #leg = 1;
  #length = null; // of another leg than the first, as text
  #own = null; // the singular curves of its slice
  #key = ""; // of the geometry and the leg
  #triangles = null;
  #reach = 1;
  #surface = null;
  #document = null; // of the cusp curves
  #edges = [];
  #events = [];
  #fault = ""; // why there are no edges
  #box = null;
  #colours = null;
  #isDue = false;
  #eye = null; // the camera as the page knows it
  #wanted = null; // {l1, place}: a cusp to be selected when its slice is there
  #timers = {};
  #names = []; // of cusps: {place, name, index}
  #chosen = -1; // the edge of the selected cusp
  #walls = ""; // that are drawn
  #texts = [];
  #ready; // a promise of the first picture
  #isReady;

  /** Fills an element. `told` has `onSelect(index)`, `onGo(l1)`, `onEye(text)` and `ask(name, question, options)`. */
  constructor(root, told) {
    this.#told = told;
    this.#ready = new Promise((resolve) => (this.#isReady = resolve));
    this.#fill(root);
    this.#paint();
    const { board } = this.#nodes;
    bindTurning(board, this.#camera, { onMove: () => this.#moved(), onPick: (...at) => this.#pick(...at), onHover: (...at) => this.#hover(...at) });
    new ResizeObserver(() => this.#resize()).observe(board);
    on(dark, "change", () => this.#paint());
  }

  #fill(root) {
    const label = "Joint space in three dimensions: arrow keys turn it, plus and minus magnify it, 0 shows all";
    const [canvas, flat] = [0, 1].map(() => make("canvas", { ariaHidden: true }));
    const over = shape("svg", { class: "over", "aria-hidden": "true" });
    const board = make("div", { id: "space-board", className: "board", tabIndex: 0, role: "application", ariaLabel: label }, canvas, flat, over);
    const legs = [1, 2, 3].map((leg) => {
      const radio = make("input", { type: "radio", name: "space-leg", value: leg, checked: leg === 1 });
      on(radio, "change", () => this.#fix(leg, null));
      return make("label", {}, radio, `${leg}`);
    });
    const slider = make("input", { type: "range", id: "space-length", min: 1, max: STEPS, hidden: true });
    on(slider, "input", () => this.#slide(between(((slider.value - 0.5) / STEPS) * this.#reach, ((Number(slider.value) + 0.5) / STEPS) * this.#reach)));
    const length = make("output", { id: "space-named", htmlFor: "space-length" });
    const choice = make("fieldset", { className: "choice", id: "space-legs" }, make("legend", { textContent: "Slices of leg" }), ...legs);
    const large = make("button", { id: "space-large", textContent: "Large", ariaPressed: false });
    on(large, "click", () => {
      large.ariaPressed = large.ariaPressed !== "true";
      root.closest("#boards").classList.toggle("large", large.ariaPressed === "true");
    });
    const note = make("p", { id: "space-note", className: "hint" });
    root.replaceChildren(board, make("div", { id: "space-controls" }, choice, length, slider, large, note), make("ul", { id: "space-marks", className: "legend", ariaLabel: "Lines and marks of the space" }));
    this.#nodes = { board, canvas, flat, over, slider, choice };
    const context = canvas.getContext("webgl2", { antialias: true, powerPreference: "high-performance" });
    const told = { onLost: () => this.#lose(true), onBack: () => this.#lose(false) };
    if (context) this.#webGl = new WebGlDrawing(canvas, context, told);
    this.#flat = new CanvasDrawing(flat);
    this.#choose();
  }

  get #drawing() {
    return this.#webGl && !this.#isLost ? this.#webGl : this.#flat;
  }

  #choose() {
    const isFlat = this.#drawing === this.#flat;
    this.#nodes.canvas.hidden = isFlat;
    this.#nodes.flat.hidden = !isFlat;
    this.#nodes.board.dataset.drawing = isFlat ? "lines" : "webgl";
  }

  /** The browser takes the graphics away, or gives them back. */
  #lose(isLost) {
    this.#isLost = isLost;
    this.#choose();
    this.#resize();
    this.#paint();
  }

  /** Takes what the page shows. */
  set(shown) {
    const before = this.#shown;
    this.#shown = { ...shown };
    if (shown.eye !== this.#eye) this.#look(shown.eye);
    this.#take(geometryText(shown.geometry));
    const isOther = (...names) => names.some((name) => shown[name] !== before[name]);
    if (this.#leg === 1 && isOther("curves")) this.#drawSlice();
    if (isOther("path", "limits")) this.#drawPaths();
    if (isOther("slice", "selected", "isShown", "here", "at", "l1")) this.#drawMarks();
    const { l1, place } = this.#wanted ?? {};
    if (l1 && shown.slice?.l1 === l1 && shown.l1 === l1) {
      this.#wanted = null;
      this.#select(place);
    }
    this.#later();
  }

  #look(eye) {
    this.#eye = eye;
    this.#camera.take(eye);
    const [leg, length] = (eye ?? "").split(";")[1]?.split(",") ?? ["1", null];
    if (["1", "2", "3"].includes(leg) && (Number(leg) !== this.#leg || length !== this.#length)) this.#fix(Number(leg), toNumber(length) > 0 ? length : null);
  }

  /** Takes a geometry and the leg: asks for the surface at once, for the edges at rest. */
  #take(text) {
    const key = `${text} ${this.#leg}`;
    const lengths = key === this.#key ? null : measured(this.#shown.geometry);
    if (lengths) {
      const isFirst = this.#key === "";
      this.#key = key;
      this.#triangles = { base: basePoints(lengths), platform: platformPoints(lengths, [0, 0], 0) };
      [this.#document, this.#edges, this.#events, this.#fault] = [null, [], [], ""];
      this.#reach = this.#wantedReach;
      this.#drawEdges();
      clearTimeout(this.#timers.geometry);
      const settle = () => {
        this.#makeSurface(GRID);
        this.#askEdges();
      };
      this.#makeSurface(COARSE);
      this.#timers.geometry = setTimeout(settle, isFirst ? 0 : REST);
    } else if (this.#level > this.#reach) this.#extend();
  }

  /** The length of the slice. */
  get #level() {
    return toNumber((this.#leg === 1 ? this.#shown.l1 : this.#length) ?? "") || 0;
  }

  /** The length up to which there is something to see. */
  get #wantedReach() {
    const sides = Object.values(this.#triangles).flatMap((points) => points.map(([x, y], k) => Math.hypot(x - points[(k + 1) % 3][0], y - points[(k + 1) % 3][1])));
    const ends = (this.#document?.curves ?? []).flatMap(({ from, to }) => [from, to]).map((end) => Number(end[`l${this.#leg}`] ?? 0));
    return Math.max(this.#document ? BEYOND * Math.max(...ends, ...sides) : GUESS * Math.max(...sides), BEYOND * this.#level);
  }

  /** Shows as much as there is to see now. */
  #extend() {
    const reach = this.#wantedReach;
    if (Math.abs(reach - this.#reach) > OTHER * this.#reach) {
      this.#reach = reach;
      this.#makeSurface(GRID);
    }
    this.#followEdges();
  }

  async #makeSurface(grid) {
    const [reach, leg] = [this.#reach, this.#leg];
    const mesh = await this.#work.ask("surface", { triangles: this.#triangles, leg, reach, grid });
    if (!mesh) return;
    this.#surface = mesh;
    const low = mesh.low.map((x, k) => (x < LOW * mesh.high[k] ? 0 : x));
    this.#box = { low, high: mesh.high.with(leg - 1, reach) };
    this.#camera.frame(low, this.#box.high);
    this.#drawing.surface(mesh);
    this.#drawPaths();
    this.#drawMarks();
    Object.assign(this.#nodes.board.dataset, { grid: grid.join(), box: JSON.stringify(this.#box) });
    this.#later();
    this.#isReady();
  }

  async #askEdges() {
    const [key, { geometry }] = [this.#key, this.#shown];
    const onRefusal = (reason) => (this.#fault = reason);
    const question = ["v1/cusp-curves", { geometry, digits: WHILE_MOVING, ...(this.#leg > 1 ? { fixed_leg: this.#leg } : {}) }];
    const document = await this.#told.ask("edges", question, { onRefusal });
    if (key !== this.#key) return;
    this.#document = document;
    if (document) this.#extend();
    else this.#drawEdges();
  }

  async #followEdges() {
    if (!this.#document) return;
    const { leg, reach, triangles, document } = { leg: this.#leg, reach: this.#reach, triangles: this.#triangles, document: this.#document };
    const found = await this.#work.ask("edges", { triangles, leg, reach, document });
    if (!found || document !== this.#document) return;
    this.#edges = found.lines;
    this.#events = found.events.filter(({ length }) => Number(length) <= reach);
    this.#drawEdges();
    this.#drawMarks();
    this.#later();
  }

  /** Fixes a leg, with the slice at a length. */
  #fix(leg, length) {
    const middle = this.#surface ? (this.#surface.low[leg - 1] + this.#surface.high[leg - 1]) / 4 : null;
    [this.#leg, this.#length, this.#own] = [leg, leg === 1 ? null : (length ?? (middle && between(0.95 * middle, 1.05 * middle))), null];
    this.#nodes.choice.querySelector(`[value="${leg}"]`).checked = true;
    this.#nodes.slider.hidden = leg === 1;
    if (!this.#shown.geometry) return;
    this.#take(geometryText(this.#shown.geometry));
    this.#slide(this.#length);
    this.#moved();
  }

  /** Takes the length of another leg than the first for its slice. */
  async #slide(length) {
    this.#length = length;
    write("space-named", this.#leg > 1 && length ? `L${this.#leg} = ${length}` : "");
    if (this.#leg === 1 || !length) return void this.#drawSlice();
    const [leg, { geometry }, { slider }] = [this.#leg, this.#shown, this.#nodes];
    slider.value = Math.round((STEPS * toNumber(length)) / this.#reach);
    slider.ariaLabel = `Length L${leg} of the slice`;
    slider.ariaValueText = `L${leg} = ${length}`;
    const [path, { l1: _, ...rest }] = pictureOf({ geometry, l1: length });
    this.#told.ask("slice of the space", [path, { ...rest, fixed_leg: leg, [`l${leg}`]: length }], { onRefusal() {} }).then((curves) => {
      if (!curves || leg !== this.#leg || geometry !== this.#shown.geometry) return;
      this.#own = curves;
      this.#drawSlice();
      this.#moved();
    });
  }

  /** Takes the colours of the style sheet, and draws all anew. */
  #paint() {
    const probe = make("span");
    this.#nodes.board.append(probe);
    const colourOf = (name) => {
      probe.style.color = `var(--${name})`;
      return getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map((part) => Number(part) / 255);
    };
    this.#colours = Object.fromEntries(COLOURS.map((name) => [name, colourOf(name)]));
    probe.remove();
    this.#pour();
  }

  #pour() {
    const { card: paper, ink, more, fewer } = this.#colours;
    this.#drawing.colours({ paper, ink, more, fewer }, ALPHAS[dark.matches ? "dark" : "light"]);
    this.#drawing.surface(this.#surface);
    this.#walls = "";
    this.#drawEdges();
    this.#drawSlice();
    this.#drawPaths();
    this.#later();
  }

  #drawEdges() {
    const chosen = this.#chosenEdge;
    const lines = this.#edges.map(({ points }, k) => ({ points, colour: this.#colours.cusp, width: k === chosen ? 5.5 : 2.6 }));
    this.#drawing.lines("edges", lines, { isTube: true });
    this.#nodes.board.dataset.edges = this.#edges.length;
    this.#explain();
  }

  /** The cusp that is selected in the slice of the page, at (L1, L2, L3). */
  get #cusp() {
    const { slice, selected, isShown } = this.#shown;
    return isShown && slice?.cusps?.[selected] ? placeOf(slice.cusps[selected], slice.l1) : null;
  }

  get #chosenEdge() {
    return this.#cusp && this.#box ? edgeNear(this.#edges, this.#cusp, NEAR * Math.hypot(...this.#box.high)) : -1;
  }

  /** The singular curves of the slice that is shown, as a document. */
  get #curves() {
    return this.#leg === 1 ? this.#shown.curves : this.#own;
  }

  /** The length of the slice that is drawn; null without one. */
  get #drawnLevel() {
    const curves = this.#curves;
    return curves ? toNumber(curves[`l${this.#leg}`]) : null;
  }

  #drawSlice() {
    const [curves, leg, level] = [this.#curves, this.#leg, this.#drawnLevel];
    const names = [1, 2, 3].map((k) => `l${k}`);
    const placesOf = (samples) => samples[names[leg % 3]].map((_, n) => names.map((name, k) => (k === leg - 1 ? level : samples[name][n])));
    const strands = (curves?.components ?? []).flatMap((component) => component.strands);
    const areas = (curves?.regions ?? []).filter(({ bounded }) => bounded).map(({ rings, poses }) => ({
      rings: rings.map(placesOf),
      colour: this.#colours[{ 2: "two", 4: "four", 6: "six" }[poses]] ?? this.#colours.two,
      alpha: 0.8,
    }));
    this.#drawing.lines("slice", strands.map((strand) => ({ points: placesOf(strand), colour: this.#colours.ink, width: 1.7 })));
    this.#drawing.plane(areas, leg - 1);
    this.#drawMarks();
    this.#explain();
  }

  /** The loop, and joint limits. */
  #drawPaths() {
    if (!this.#box) return;
    const [colours, { path = [], limits }] = [this.#colours, this.#shown];
    this.#drawing.lines("loop", path.length > 1 ? [{ points: path.map(placeIn), colour: colours.loop, width: 5 }] : [], { isTube: true });
    this.#drawing.lines("limits", limits ? limitLines(limits, this.#box).map((points) => ({ points, colour: colours.accent, width: 1.8 })) : []);
    this.#explain();
  }

  /** What is marked: events, cusps of the slice, a joint vector, and where the machine is on the loop. */
  #drawMarks() {
    if (!this.#box) return;
    const [colours, { slice, selected, isShown, here, at, l1 }] = [this.#colours, this.#shown];
    const marks = this.#events.map(({ kind, place }) => ({ place, colour: colours.ink, form: FORMS[kind] ?? FORMS.dot, size: kind in FORMS ? EVENT : 0.7 * EVENT }));
    this.#names = [];
    if (isShown) {
      (slice.cusps ?? []).forEach((cusp, k) => {
        if (this.#leg !== 1 && k !== selected) return;
        const place = placeOf(cusp, slice.l1);
        marks.push({ place, colour: colours.cusp, form: k === selected ? FORMS.dot : FORMS.ring, size: k === selected ? CUSP + 3 : CUSP });
        this.#names.push({ place, name: letterOf(k), index: k });
      });
    }
    if (at) marks.push({ place: [l1, at.l2, at.l3].map(toNumber), colour: colours.ink, form: FORMS.dot, size: CUSP + 2 });
    if (here) marks.push({ place: placeIn(here), colour: colours.loop, form: FORMS.dot, size: HERE });
    this.#drawing.marks(marks);
    const chosen = this.#chosenEdge;
    if (chosen !== this.#chosen) {
      this.#chosen = chosen;
      this.#drawEdges();
    } else this.#explain();
  }

  #explain() {
    const kinds = new Set(this.#events.map(({ kind }) => kind));
    const { path = [], limits, isShown, slice, at } = this.#shown;
    const [hasSurface, isFlat] = [Boolean(this.#surface), this.#drawing === this.#flat];
    const modes = new Set((this.#curves?.regions ?? []).filter(({ bounded }) => bounded).map(({ poses }) => poses));
    showLegend([
      { name: "space-more", text: "surface, the side with more poses", if: hasSurface && !isFlat },
      { name: "space-fewer", text: "with fewer", if: hasSurface && !isFlat },
      { name: "space-contour", as: "line", text: "contours of the surface", if: hasSurface && isFlat },
      { name: "space-edge", as: "line", text: "cusp curve", if: this.#edges.length > 0 },
      ...Object.entries(SHAPES).map(([kind, d]) => ({ name: "space-event", as: "path", d, text: kind, if: kinds.has(kind) })),
      { name: "space-event", as: "mark", text: "other degenerate pose", if: [...kinds].some((kind) => !(kind in SHAPES)) },
      { name: "singular", as: "line", text: "slice", if: Boolean(this.#curves) },
      ...[2, 4, 6].map((poses) => ({ name: `modes-${poses}`, text: `${poses} poses`, if: modes.has(poses) })),
      { name: "cusp", as: "mark", text: "cusp", if: Boolean(isShown && slice?.cusps?.length) },
      { name: "loop", as: "line", text: "loop", if: path.length > 0 },
      { name: "pose-point chosen", as: "mark", text: "joint vector", if: Boolean(at) },
      { name: "limits", as: "area", text: "joint limits", if: Boolean(limits) },
    ], "space-marks");
    const edges = this.#fault ? `No cusp curves: ${this.#fault}.` : this.#document ? "Exact: curves, marks, slice." : "Cusp curves come …";
    write("space-note", `${edges} By a grid of ${GRID.join(" × ")}: the surface.`);
  }

  #pick(x, y, reach) {
    const named = this.#names.map(({ place, index }) => ({ index, seen: this.#camera.project(place) }));
    const near = named.map(({ index, seen }) => ({ index, away: Math.hypot(seen[0] - x, seen[1] - y) })).sort((one, other) => one.away - other.away)[0];
    if (near?.away <= reach) return this.#told.onSelect(near.index);
    const found = edgeAt(this.#edges, this.#camera, x, y, reach);
    if (!found) return undefined;
    const most = NEAR * Math.hypot(...this.#box.high);
    const { slice, isShown } = this.#shown;
    const own = isShown ? (slice.cusps ?? []).some((cusp) => edgeNear(this.#edges, placeOf(cusp, slice.l1), most) === found.k) : false;
    if (own) return this.#select(found.place, found.k);
    const [low, high] = this.#leg === 1 ? found.line.ends.map((end, k) => toNumber(end ?? "") || [0, Infinity][k]) : [0, Infinity];
    const [length, half] = [found.place[0], this.#reach / 2000];
    const l1 = between(Math.max(length - half, low), Math.min(length + half, high));
    if (!l1) return undefined;
    this.#wanted = { l1, place: found.place };
    return this.#told.onGo(l1);
  }

  /** Selects the cusp of the slice that is nearest to a place, on an edge if one is named. */
  #select(place, edge = -1) {
    const { cusps, l1 } = this.#shown.slice;
    const most = NEAR * Math.hypot(...this.#box.high);
    const far = cusps.map((cusp, index) => {
      const at = placeOf(cusp, l1);
      const isOther = edge >= 0 && edgeNear(this.#edges, at, most) !== edge;
      return { index, away: isOther ? Infinity : Math.hypot(...at.map((x, k) => x - place[k])) };
    }).sort((one, other) => one.away - other.away);
    if (far.length > 0) this.#told.onSelect(far[0].index);
  }

  #hover(x, y, reach) {
    const { board } = this.#nodes;
    const named = this.#names.find(({ place }) => {
      const [u, v] = this.#camera.project(place);
      return Math.hypot(u - x, v - y) <= reach;
    });
    const event = this.#events.find(({ place }) => {
      const [u, v] = this.#camera.project(place);
      return Math.hypot(u - x, v - y) <= reach;
    });
    const found = named || event ? null : edgeAt(this.#edges, this.#camera, x, y, reach);
    const words = named ? `Cusp ${named.name}` : event ? `${event.kind}: L${this.#leg} = ${shortened(event.length)}` : found ? this.#spoken(found) : "";
    board.style.cursor = words ? "pointer" : "grab";
    if (words) board.dataset.what = words;
    else delete board.dataset.what;
  }

  #spoken({ line: { name, from, to, ends }, place }) {
    const end = (kind, k) => (ends[k] && kind !== "open" ? `${kind} at L${this.#leg} = ${shortened(ends[k])}` : k ? "∞" : "0");
    const [l1, l2, l3] = place.map((x) => shortened(x, 4));
    return `Edge ${name}, from ${end(from, 0)} to ${end(to, 1)}; here L1 = ${l1}, L2 = ${l2}, L3 = ${l3}`;
  }

  /** Magnifies by a factor about the selected cusp; shows all without one. */
  zoom(factor) {
    if (!factor) this.#camera.showAll();
    else {
      if (factor > 1 && this.#cusp) this.#camera.look(this.#cusp);
      this.#camera.zoomAbout(factor);
    }
    this.#moved();
  }

  #moved() {
    this.#later();
    clearTimeout(this.#timers.eye);
    this.#timers.eye = setTimeout(() => {
      this.#eye = this.#camera.text + (this.#leg > 1 ? `;${this.#leg},${this.#length ?? ""}` : "");
      this.#told.onEye(this.#eye);
    }, REST);
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#nodes.board;
    if (!width || !height) return;
    this.#camera.resize(width, height);
    this.#size(this.#drawing === this.#webGl && this.#webGl.isSoftware ? 1 : Math.min(devicePixelRatio, 2));
    this.#later();
  }

  #size(density) {
    const { clientWidth: width, clientHeight: height } = this.#nodes.board;
    this.#drawing.resize(width, height, density, Math.min(Math.max(Math.min(width, height) / WHOLE, LEAST), 1));
  }

  #later() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame(() => {
      this.#isDue = false;
      this.#draw();
    });
  }

  #draw() {
    const { board, over } = this.#nodes;
    if (!this.#box || !board.clientWidth) return;
    this.#render();
    over.replaceChildren(...this.#texts.map(({ text, x, y, name }) => symbol(text, { class: name, x, y: y + 4, "text-anchor": "middle" })));
    board.dataset.eye = this.#camera.text;
    board.dataset.pictures = Number(board.dataset.pictures ?? 0) + 1;
  }

  #render() {
    const { clientWidth: width, clientHeight: height } = this.#nodes.board;
    const { key, lines, texts } = frameOf(this.#camera, this.#box, [width, height]);
    if (key !== this.#walls) this.#drawing.lines("walls", lines.map((points) => ({ points, colour: this.#colours.line, width: 1 })), { isBehind: true });
    this.#walls = key;
    const axis = this.#leg - 1;
    const ticks = ticksOf(this.#box.low[axis], this.#box.high[axis], CONTOURS);
    this.#drawing.render(this.#camera, { axis, level: this.#drawnLevel, spacing: ticks[1] - ticks[0] || 1 });
    const spots = this.#names.map(({ place, name }) => {
      const [x, y] = this.#camera.project(place);
      return { x, y, name };
    });
    const box = { left: 4, right: width - 4, top: 4, bottom: height - 4 };
    const names = namesOf(spots, spots.map(({ name }) => name), box).map(({ text, at: [x, y] }) => ({ text, x, y, name: "name halo" }));
    this.#texts = [...texts.map(({ text, x, y, isName }) => ({ text, x, y, name: isName ? "axis-name halo" : "tick-label halo" })), ...names];
  }

  /** The picture with its texts on a canvas of its own, when there is one. */
  async image() {
    await this.#ready;
    const { board, canvas: own, flat } = this.#nodes;
    const [width, height] = [board.clientWidth, board.clientHeight];
    this.#size(SCALE);
    this.#render();
    const canvas = make("canvas", { width: SCALE * width, height: SCALE * height });
    const context = canvas.getContext("2d");
    const css = (name) => `rgb(${this.#colours[name].map((x) => Math.round(255 * x)).join(" ")})`;
    context.fillStyle = css("card");
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(this.#drawing === this.#flat ? flat : own, 0, 0);
    context.scale(SCALE, SCALE);
    Object.assign(context, { textAlign: "center", lineJoin: "round", lineWidth: 3, strokeStyle: css("card"), fillStyle: css("ink") });
    for (const { text, x, y, name } of this.#texts) {
      context.font = `${name.startsWith("name") ? "600 13px" : "11px"} system-ui, sans-serif`;
      context.strokeText(text, x, y + 4);
      context.fillText(text, x, y + 4);
    }
    this.#resize();
    return canvas;
  }
}

const placeOf = ({ l2, l3 }, l1) => [l1, l2, l3].map(toNumber);

const placeIn = ({ l1, l2, l3 }) => [l1, l2, l3].map(Number);

/** The edges of the box of joint limits, within the box that is shown. */
function limitLines(limits, { low, high }) {
  const ends = [1, 2, 3].map((leg, k) => [["min", low], ["max", high]].map(([name, open]) => {
    const value = toNumber(limits[`l${leg}`]?.[name] ?? "");
    return Number.isFinite(value) ? Math.min(Math.max(value, low[k]), high[k]) : open[k];
  }));
  return [0, 1, 2].flatMap((axis) => [0, 1].flatMap((p) => [0, 1].map((q) => [0, 1].map((end) => {
    const others = [0, 1, 2].filter((other) => other !== axis);
    return [0, 0, 0].with(axis, ends[axis][end]).with(others[0], ends[others[0]][p]).with(others[1], ends[others[1]][q]);
  }))));
}
