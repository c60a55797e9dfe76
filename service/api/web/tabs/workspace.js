/** "Workspace": the places that the limits of the legs allow at one orientation, by the sign of J, and the machine at one of them. */

import { decimal, pointed, shortened, toNumber } from "../explorer/decimals.js";
import { byId, on, shape, write } from "../explorer/dom.js";
import { basePoints, measured, platformPoints } from "../explorer/geometry.js";
import { vectorOf } from "../explorer/kinematics.js";
import { geometryText } from "../explorer/state.js";
import { arcOf, contourOf } from "./arcs.js";

const LEGS = ["l1", "l2", "l3"];
const DEGREES = Math.PI / 180;
const PAUSE = 80; // ms in which the slider stands still before the service is asked
const SIDE = 360; // of the picture, in its own unit
const MARGIN = 0.06; // beside what is shown, by its size
const STEP = 0.01; // of the picture, that an arrow key moves the place
const SHARE = 0.4; // by which limits that are proposed differ from the lengths that are shown
const FILLS = { 1: "plus-1", "-1": "minus-1", 0: "modes-2" };

const MARKUP = `
<p class="hint">The places that the <button class="term" data-term="joint limits">limits</button> of the legs (tab Limits) allow at one
orientation, and where J = 0 divides them. Click or drag: the machine stands there.</p>
<div class="player"><label for="workspace-phi">φ [°]</label><input id="workspace-phi" inputmode="decimal" value="0">
<input id="workspace-slider" type="range" min="-180" max="180" step="1" value="0" aria-label="Orientation φ"></div>
<svg id="workspace-picture" role="group" aria-label="Workspace" viewBox="0 0 ${SIDE} ${SIDE}"></svg>
<ul id="workspace-legend" class="legend" aria-label="Lines and areas of the workspace"></ul>
<p id="workspace-verdict" class="count" aria-live="polite"></p>
<p id="workspace-place"></p>
<div class="buttons"><button id="workspace-show" hidden>Show this pose</button>
<button id="workspace-propose" hidden>Limits within ${100 * SHARE} % of the shown lengths</button></div>`;

export class Panel {
  #section;
  #told;
  #state = null;
  #shown = null; // what was asked, as text
  #plane = null; // what is drawn
  #place = null; // of the platform
  #machine = null; // its group
  #timer = null;

  /** `ask` asks about the state, `onLimits(limits)` is told which limits are to be kept, `onPose(pose)` which pose is to be shown. */
  constructor(section, told) {
    [this.#section, this.#told] = [section, told];
    section.innerHTML = MARKUP;
    const [slider, field, picture] = ["workspace-slider", "workspace-phi", "workspace-picture"].map(byId);
    on(slider, "input", () => this.#turn(slider.value));
    on(field, "input", () => this.#turn(pointed(field.value)));
    on("workspace-propose", "click", () => told.onLimits(this.#proposed));
    on("workspace-show", "click", () => told.onPose(this.#plane.poseAt(this.#place)));
    on(picture, "pointerdown", (event) => {
      picture.setPointerCapture(event.pointerId);
      this.#put(this.#placeOf(event));
    });
    on(picture, "pointermove", (event) => event.buttons && this.#put(this.#placeOf(event)));
    on(picture, "keydown", (event) => this.#key(event));
  }

  show(state) {
    this.#state = state;
    if (!this.#section.hidden) this.#ask();
  }

  #turn(phi) {
    if (byId("workspace-phi").value !== phi) byId("workspace-phi").value = phi;
    if (Number.isFinite(toNumber(phi))) byId("workspace-slider").value = toNumber(phi);
    byId("workspace-slider").ariaValueText = `φ = ${phi} degrees`;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#ask(), PAUSE);
  }

  /** Limits about the lengths that are shown. */
  get #proposed() {
    const { geometry, here } = this.#state;
    const lengths = vectorOf(measured(geometry), { l1: toNumber(here.l1), alpha_deg: Number(here.alpha_deg), theta1_deg: Number(here.theta1_deg) });
    return Object.fromEntries(LEGS.map((leg, k) => [leg, { min: decimal((1 - SHARE) * lengths[k], 1), max: decimal((1 + SHARE) * lengths[k], 1) }]));
  }

  async #ask() {
    const { geometry, limits } = this.#state;
    const phi = pointed(byId("workspace-phi").value);
    const question = JSON.stringify([geometryText(geometry), phi, limits]);
    if (question === this.#shown) return;
    this.#shown = question;
    const isBounded = LEGS.some((leg) => limits?.[leg]?.max);
    byId("workspace-propose").hidden = isBounded;
    if (!isBounded) return this.#none("No leg has a greatest length: the workspace has no end. Enter limits in the tab Limits, or take these.");
    const onRefusal = (reason) => this.#none(reason.replace("phi: ", "φ "));
    const answer = await this.#told.ask("workspace", () => ["v1/workspaces", { geometry, phi, limits }], { onRefusal, hasFields: true });
    if (answer && question === this.#shown) this.#draw(answer);
  }

  #none(reason) {
    this.#plane = null;
    byId("workspace-picture").replaceChildren();
    byId("workspace-legend").replaceChildren();
    byId("workspace-show").hidden = true;
    write("workspace-verdict", reason);
    write("workspace-place", "");
  }

  #draw(answer) {
    this.#plane = new Plane(answer, this.#state.geometry);
    write("workspace-verdict", this.#plane.spoken);
    byId("workspace-show").hidden = false;
    const regions = this.#plane.picture();
    this.#machine = shape("g", { class: "machine" });
    byId("workspace-picture").replaceChildren(...regions, this.#machine);
    byId("workspace-legend").replaceChildren(...this.#plane.legend());
    this.#put(this.#place && this.#plane.isIn(this.#place) ? this.#place : this.#plane.middle);
  }

  #placeOf(event) {
    const box = byId("workspace-picture").getBoundingClientRect();
    return this.#plane?.placeAt([((event.clientX - box.left) / box.width) * SIDE, ((event.clientY - box.top) / box.height) * SIDE]);
  }

  #key(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!way || !this.#plane) return;
    event.preventDefault();
    this.#put(this.#place.map((x, axis) => x + STEP * this.#plane.size * way[axis]));
  }

  #put(place) {
    if (!this.#plane || !place) return;
    const hadFocus = this.#machine.contains(document.activeElement);
    this.#place = place;
    this.#machine.replaceChildren(...this.#plane.machineAt(place));
    const lengths = this.#plane.lengthsAt(place);
    const words = `x = ${shortened(place[0], 5)}, y = ${shortened(place[1], 5)}: ${lengths.map((length, k) => `L${k + 1} = ${shortened(length, 5)}`).join(", ")}`;
    const out = LEGS.filter((leg, k) => !this.#plane.keeps(leg, lengths[k])).map((leg) => leg.toUpperCase());
    write("workspace-place", words + (out.length > 0 ? `; outside the limits of ${out.join(", ")}` : ""));
    const point = this.#machine.lastChild;
    for (const [name, value] of Object.entries({ tabindex: 0, role: "img", "aria-roledescription": "point that the arrow keys move", "aria-label": `Place of the platform, ${words}` })) point.setAttribute(name, value);
    if (hadFocus) point.focus();
  }
}

/** The plane of the places of an answer, and where it is in the picture. */
class Plane {
  #answer;
  #lengths;
  #base; // A1, A2, A3
  #platform; // B1, B2, B3 from the place of the platform, turned
  #loops; // of each region its loops, each the points of its arcs
  #view; // {left, top, size}

  constructor(answer, geometry) {
    [this.#answer, this.#lengths] = [answer, measured(geometry)];
    const { points = {}, regions } = answer;
    const [c, s] = [Math.cos, Math.sin].map((f) => f(toNumber(answer.phi_deg) * DEGREES));
    const given = (corners) => corners?.map((corner) => corner.map(toNumber));
    this.#base = given(points.base) ?? basePoints(this.#lengths);
    const corners = given(points.platform) ?? platformPoints(this.#lengths, [0, 0], 0);
    this.#platform = corners.map(([x, y]) => [c * x - s * y, s * x + c * y]);
    const coefficients = ["xx", "xy", "yy", "x", "y", "1"].map((name) => Number(answer.conic.coefficients[name]));
    this.conic = { kind: answer.conic.kind, coefficients };
    this.#loops = regions.map(({ boundary }) => boundary.map((loop) => loop.map((arc) => this.#points(arc))));
    this.#fit();
  }

  #points(arc) {
    const [leg, end] = arc.on.split("_");
    const k = LEGS.indexOf(leg);
    const circle = k < 0 ? null : { centre: this.#centre(k), radius: toNumber(this.#answer.limits[leg][end]) };
    return arcOf(arc, this.#answer.vertices.map(({ x, y }) => [Number(x), Number(y)]), circle, this.conic);
  }

  /** Where the platform is when leg k has length 0. */
  #centre(k) {
    return [0, 1].map((axis) => this.#base[k][axis] - this.#platform[k][axis]);
  }

  #fit() {
    const points = [...this.#loops.flat(3), ...this.#base];
    const [[x0, x1], [y0, y1]] = [0, 1].map((axis) => {
      const values = points.map((point) => point[axis]);
      return [Math.min(...values), Math.max(...values)];
    });
    const size = (1 + 2 * MARGIN) * Math.max(x1 - x0, y1 - y0, 1e-9);
    this.#view = { left: (x0 + x1 - size) / 2, top: (y0 + y1 + size) / 2, size };
  }

  get size() {
    return this.#view.size;
  }

  #at([x, y]) {
    const { left, top, size } = this.#view;
    return [((x - left) * SIDE) / size, ((top - y) * SIDE) / size];
  }

  placeAt([u, v]) {
    const { left, top, size } = this.#view;
    return [left + (u * size) / SIDE, top - (v * size) / SIDE];
  }

  #line(points, isClosed = false) {
    return `M${points.map((point) => this.#at(point).map((x) => x.toFixed(2)).join(" ")).join("L")}${isClosed ? "Z" : ""}`;
  }

  picture() {
    const { regions, limits, thin, isolated, vertices } = this.#answer;
    const areas = regions.map(({ sign, area }, k) => shape("path", {
      class: `area ${FILLS[sign]}`, d: this.#loops[k].map((loop) => this.#line(loop.flat(), true)).join(""),
    }));
    const circles = LEGS.flatMap((leg, k) => Object.values(limits[leg] ?? {}).filter((end) => toNumber(end) > 0).map((end) => {
      const [cx, cy] = this.#at(this.#centre(k));
      return shape("circle", { class: `limit leg-${k + 1}`, cx, cy, r: (toNumber(end) * SIDE) / this.#view.size });
    }));
    const contour = this.conic.kind === "plane" ? [] : contourOf(this.conic.coefficients, this.#view).map((segment) => this.#line(segment));
    const edges = [...regions.flatMap(({ boundary }, k) => boundary.flatMap((loop, i) => loop.map((arc, j) => [arc, this.#loops[k][i][j]]))),
      ...thin.map((arc) => [arc, this.#points(arc)])];
    const arcs = edges.map(([{ on: curve }, points]) => shape("path", { class: curve === "singular" ? "edge conic" : `edge leg-${curve[1]}`, d: this.#line(points) }));
    const alone = isolated.map((number) => {
      const [cx, cy] = this.#at([Number(vertices[number - 1].x), Number(vertices[number - 1].y)]);
      return shape("circle", { class: "cusp", cx, cy, r: 4 });
    });
    return [...areas, ...circles, shape("path", { class: "conic", d: contour.join("") }), ...arcs, ...alone];
  }

  legend() {
    const item = (name, text) => {
      const sample = shape("svg", { viewBox: "0 0 20 12", "aria-hidden": "true" });
      sample.append(name.startsWith("area") ? shape("rect", { class: name, width: 20, height: 12 }) : shape("path", { class: name, d: "M0 6H20" }));
      const line = document.createElement("li");
      line.append(sample, text);
      return line;
    };
    const signs = [...new Set(this.#answer.regions.map(({ sign }) => sign))];
    return [
      ...signs.map((sign) => item(`area ${FILLS[sign]}`, `J ${sign > 0 ? ">" : sign < 0 ? "<" : "="} 0`)),
      ...(this.conic.kind === "plane" ? [] : [item("edge conic", `J = 0: ${this.conic.kind}`)]),
      ...LEGS.filter((leg) => this.#answer.limits[leg]).map((leg) => item(`edge leg-${leg[1]}`, `limits of ${leg.toUpperCase()}`)),
    ];
  }

  /** What is proved. */
  get spoken() {
    const { regions, area } = this.#answer;
    const parts = [["positive", 1, "J > 0"], ["negative", -1, "J < 0"], ["singular", 0, "J = 0"]].flatMap(([name, sign, words]) => {
      const count = regions.filter((region) => region.sign === sign).length;
      return count > 0 ? [`${words} in ${count} region${count > 1 ? "s" : ""} of ${shortened(area[name], 6)}`] : [];
    });
    return parts.length > 0 ? `${parts.join(", ")}. Proved.` : "No place is allowed. Proved.";
  }

  /** The corners of the platform at a place. */
  #corners(place) {
    return this.#platform.map((corner) => [0, 1].map((axis) => corner[axis] + place[axis]));
  }

  lengthsAt(place) {
    return this.#corners(place).map(([x, y], k) => Math.hypot(x - this.#base[k][0], y - this.#base[k][1]));
  }

  keeps(leg, length) {
    const { min, max } = this.#answer.limits[leg] ?? {};
    return length >= toNumber(min ?? "0") && length <= (max === undefined || max === null ? Infinity : toNumber(max));
  }

  isIn(place) {
    return this.lengthsAt(place).every((length, k) => this.keeps(LEGS[k], length));
  }

  /** A place in the largest region, far from its boundary. */
  get middle() {
    const { regions } = this.#answer;
    if (regions.length === 0) return [0, 1].map((axis) => (this.#base[0][axis] + this.#base[1][axis] + this.#base[2][axis]) / 3);
    const areas = regions.map(({ area }) => Number(area));
    const borders = this.#loops[areas.indexOf(Math.max(...areas))].flat(2);
    const ends = [0, 1].map((axis) => borders.map((point) => point[axis])).map((values) => [Math.min(...values), Math.max(...values)]);
    const shares = Array.from({ length: 23 }, (_, k) => (k + 1) / 24);
    const grid = shares.flatMap((u) => shares.map((v) => [u, v].map((share, axis) => ends[axis][0] + share * (ends[axis][1] - ends[axis][0]))));
    const sign = regions[areas.indexOf(Math.max(...areas))].sign;
    const far = grid.map((place) => (this.isIn(place) && Math.sign(this.#valueAt(place)) === sign ? Math.min(...borders.map(([x, y]) => Math.hypot(x - place[0], y - place[1]))) : 0));
    return grid[far.indexOf(Math.max(...far))];
  }

  #valueAt([x, y]) {
    const [a, b, c, d, e, f] = this.conic.coefficients;
    return a * x * x + b * x * y + c * y * y + d * x + e * y + f;
  }

  /** The pose at a place, in the frame of the article. */
  poseAt(place) {
    const { frame } = this.#lengths;
    const [b1] = this.#corners(place);
    const [x, y] = frame ? frame.inside(b1) : b1;
    return { l1: Math.hypot(x, y), alpha_deg: Number(this.#answer.alpha_deg), theta1_deg: Math.atan2(y, x) / DEGREES };
  }

  machineAt(place) {
    const corners = this.#corners(place);
    const [cx, cy] = this.#at(place);
    const dots = [...this.#base, ...corners].map((point) => {
      const [x, y] = this.#at(point);
      return shape("circle", { class: "joint", cx: x, cy: y, r: 3 });
    });
    return [
      shape("path", { class: "base", d: this.#line(this.#base, true) }),
      shape("path", { class: "platform", d: this.#line(corners, true) }),
      ...corners.map((corner, k) => shape("path", { class: `edge leg-${k + 1}`, d: this.#line([this.#base[k], corner]) })),
      ...dots,
      shape("circle", { class: "vector", cx, cy, r: 6 }),
    ];
  }
}
