/** The mechanism: base, legs and platform, which is moved, or whose joints are, which makes another machine. */

import { Frame, makeBoard, makeLine, makePoint, overlay, pixel, put, symbol } from "./board.js";
import { showLegend } from "./curves.js";
import { shortened, toNumber } from "./decimals.js";
import { on, shape } from "./dom.js";
import { basePoints, distance, dragged, heldDirection, isSix, measured, placeOf, placesOf, platformPoints } from "./geometry.js";
import { clearanceOf, meetingOf } from "./kinematics.js";
import { reveal } from "./panel.js";
import { geometryText } from "./state.js";

const NAMES = ["A1", "A2", "A3", "B1", "B2", "B3"];
const FREE = { move: ["B1", "B2", "B3"], design: ["A2", "A3", "B2", "B3"] }; // what can be dragged
const NEAR = 1.5; // degrees from a singular pose at which it is shown as one
const DEGREES = Math.PI / 180;
const TOUCH = { mouse: 8, touch: 24 }; // pixels round a point that are its own
const STILL = 500; // ms without a picture after which nothing moves
const AWAY = 15; // pixels from a mark to its name

export class Mechanism {
  #board = makeBoard("mechanism-board", "The manipulator");
  #lines = {
    orbit: makeLine(this.#board, "orbit", 2, "Circle of B1: its distance from A1 is L1"),
    base: makeLine(this.#board, "base", 3, "Base: A1, A2, A3 are fixed"),
    candidate: makeLine(this.#board, "candidate", 3, "A better geometry, at the same pose"),
    ghosts: makeLine(this.#board, "ghost", 3, "Another pose with the same three lengths"),
    meeting: makeLine(this.#board, "meeting", 3, `A singular pose, or one within ${NEAR}° of it: the lines of the legs meet in a point, about which the platform can turn a little although no length changes`),
    platform: makeLine(this.#board, "platform", 4, "Platform: B1, B2, B3 move with it"),
    legs: [0, 1, 2].map(() => makeLine(this.#board, "legs", 6)),
  };
  #write = overlay(this.#board, () => this.#labels());
  #frame = new Frame(this.#board, () => this.#extent(), { onMove: () => this.#write() });
  #points = {};
  #shown = null; // {geometry, lengths, l1, b1, alpha}
  #others = []; // other poses
  #ghosts = []; // their corners
  #names = []; // of them
  #reach = {}; // the corners of what was drawn, of which geometry and L1, and when
  #candidate = null; // the lengths of another geometry
  #isSingular = false; // whether a pose is nearly
  #meeting = null; // where the lines of its legs meet
  #held = null; // the point that is dragged, and changes the geometry
  #isMoved = false; // whether the platform is
  #mode = null;
  #onDrag;
  #onMove;

  /**
   * `onDrag(geometry)` is told each geometry on the grid while a point is dragged, `onMove(pose)` each pose while the platform
   * is, `onRest()` the end of either.
   */
  constructor({ onDrag, onMove, onRest }) {
    [this.#onDrag, this.#onMove] = [onDrag, onMove];
    const rest = () => {
      this.#held = null;
      this.#isMoved = false;
    };
    for (const name of NAMES) {
      const point = this.#points[name] = makePoint(this.#board, { cssClass: "joint", draggable: true });
      point.on("drag", () => (this.#mode === "design" ? this.#drag(name) : this.#turn(name)));
      point.on("up", () => {
        rest();
        onRest();
      });
      on(point.rendNode, "blur", rest);
    }
    this.#bindPlatform(() => {
      rest();
      onRest();
    });
    on("mechanism-all", "click", () => this.#frame.showAll());
  }

  /** Takes what a drag does: "move" the platform, or "design" another machine. */
  set mode(mode) {
    if (mode === this.#mode) return;
    this.#mode = mode;
    for (const name of NAMES) {
      const [point, isFree] = [this.#points[name], FREE[mode].includes(name)];
      const cssClass = isFree ? "handle" : "joint";
      point.setAttribute({ cssClass, highlightCssClass: cssClass, size: isFree ? 6 : 3, fixed: !isFree, highlight: isFree, tabindex: isFree ? 0 : -1 });
      const { rendNode } = point;
      rendNode.role = isFree ? "img" : null;
      rendNode.ariaRoleDescription = isFree ? "point that the arrow keys move" : null;
      rendNode.ariaHidden = isFree ? null : true;
      rendNode.ariaLabel = null;
    }
    this.#board.containerObj.classList.toggle("moves", mode === "move");
    if (this.#shown) this.#update();
  }

  isOther(geometry) {
    return this.#shown?.geometry !== geometry;
  }

  get isHeld() {
    return this.#held !== null;
  }

  /** Draws the manipulator at a pose, and others as outlines with their names; while a point is dragged, the platform stays where it is. */
  draw(geometry, pose, others = this.#others) {
    const lengths = measured(geometry);
    if (!lengths || !(toNumber(pose.l1) > 0)) return;
    const place = this.#held && this.#shown ? this.#shown : placeOf(pose);
    this.#shown = { geometry, lengths, l1: pose.l1, b1: place.b1, alpha: place.alpha };
    this.#outline(others);
    this.#update();
    this.#board.containerObj.classList.remove("empty");
    this.#follow();
  }

  #follow() {
    const point = this.#points[this.#held];
    if (point) this.#frame.followAbout([point.X(), point.Y()]);
    else if (!this.#isMoved) this.#frame.follow();
  }

  /** Takes the outlines away, the pose being kept. */
  clearOthers() {
    if (!this.#shown) return;
    this.#outline([]);
    this.#update();
  }

  #outline(poses) {
    const { lengths } = this.#shown;
    this.#others = poses;
    this.#ghosts = poses.map(placeOf).map(({ b1, alpha }) => this.#seen(platformPoints(lengths, b1, alpha)));
    this.#names = poses.map(({ name }) => name);
    this.#lines.ghosts.set(this.#ghosts.flatMap((corners) => [...corners, corners[0], null]));
  }

  drawCandidate(geometry) {
    if (!geometry && !this.#candidate) return;
    this.#candidate = geometry && measured(geometry);
    if (geometry) reveal("mechanism");
    if (this.#shown) this.#update();
  }

  /** All that is drawn, and the corners of what was while poses move: so long the frame does not come nearer again. */
  #extent() {
    if (!this.#shown) return [];
    const { geometry, lengths, l1, b1, alpha } = this.#shown;
    const now = [...this.#seen([...basePoints(lengths), ...platformPoints(lengths, b1, alpha), ...orbitOf(b1, 12)]), ...this.#ghosts.flat()];
    const { of, time, corners } = this.#reach;
    const slice = `${l1} ${geometryText(geometry)}`;
    const isMoving = !this.#held && of === slice && performance.now() - time < STILL;
    const all = [...now, ...(isMoving ? corners : [])];
    const ranges = [0, 1].map((axis) => all.map((point) => point[axis]));
    this.#reach = { of: slice, time: performance.now(), corners: [Math.min, Math.max].map((end) => ranges.map((range) => end(...range))) };
    return all;
  }

  /** Points in the frame in which the base was given. */
  #seen(points) {
    const { frame } = this.#shown.lengths;
    return frame ? points.map((point) => point && frame.outside(point)) : points;
  }

  /** A drag of the platform itself, unless it begins at a point that can be dragged. */
  #bindPlatform(onRest) {
    const { containerObj: container } = this.#board;
    let start = null;
    on(container, "pointerdown", (event) => {
      const at = (point) => pixel(this.#board, [point.X(), point.Y()]);
      const { left, top } = container.getBoundingClientRect();
      const place = [event.clientX - left, event.clientY - top];
      const near = FREE[this.#mode].some((name) => distance(at(this.#points[name]), place) < (TOUCH[event.pointerType] ?? TOUCH.touch));
      if (this.#mode !== "move" || near || event.target !== this.#lines.platform.node || !event.isPrimary) return;
      event.stopImmediatePropagation(); // else the picture would move along
      container.setPointerCapture(event.pointerId);
      start = { place: this.#inside(this.#board.getUsrCoordsOfMouse(event)), b1: this.#shown.b1 };
    }, true);
    on(container, "pointermove", (event) => {
      if (!start) return;
      const to = this.#inside(this.#board.getUsrCoordsOfMouse(event));
      this.#placed([0, 1].map((axis) => start.b1[axis] + to[axis] - start.place[axis]), this.#shown.alpha);
    });
    for (const type of ["pointerup", "pointercancel"]) on(container, type, () => {
      if (start) onRest();
      start = null;
    });
  }

  #inside(place) {
    const { frame } = this.#shown.lengths;
    return frame ? frame.inside(place) : place;
  }

  /** A corner that is dragged turns the platform about B1; B1 takes it along its circle, so that L1 is kept. */
  #turn(name) {
    const { lengths, b1, alpha } = this.#shown;
    const to = this.#inside([this.#points[name].X(), this.#points[name].Y()]);
    if (name === "B1") return this.#placed(to, alpha);
    const corners = platformPoints(lengths, b1, alpha).with(name === "B2" ? 1 : 2, to);
    return this.#placed(b1, heldDirection(lengths, name === "B2" ? "B3" : "B2", corners));
  }

  #placed([x, y], alpha) {
    this.#isMoved = true;
    this.#onMove({ l1: toNumber(this.#shown.l1), theta1_deg: Math.atan2(y, x) / DEGREES, alpha_deg: Math.atan2(Math.sin(alpha), Math.cos(alpha)) / DEGREES });
  }

  #drag(name) {
    const { geometry, lengths, l1, b1, alpha } = this.#shown;
    const to = this.#inside([this.#points[name].X(), this.#points[name].Y()]);
    const corners = platformPoints(lengths, b1, alpha);
    const next = dragged(geometry, name, to, corners, placesOf(lengths));
    if (next) {
      this.#held = name;
      const after = measured(next);
      const turned = name.startsWith("B") ? heldDirection(after, name, corners.with(name === "B2" ? 1 : 2, to)) : alpha;
      this.#shown = { geometry: next, lengths: after, l1, b1, alpha: turned };
    }
    this.#update(); // also where the point may not go
    this.#follow();
    if (next) this.#onDrag(next);
  }

  #update() {
    const { geometry, lengths, b1, alpha } = this.#shown;
    const base = this.#seen(basePoints(lengths));
    const corners = this.#seen(platformPoints(lengths, b1, alpha));
    const other = this.#candidate;
    const outlines = other ? [basePoints(other), platformPoints(other, b1, alpha)].map((outline) => this.#seen(outline)) : [];
    this.#lines.candidate.set(outlines.flatMap((outline) => [...outline, outline[0], null]));
    this.#lines.orbit.set(this.#seen(orbitOf(b1, 96)));
    this.#lines.base.set([...base, base[0]]);
    this.#lines.platform.set([...corners, corners[0]]);
    base.forEach((foot, k) => {
      this.#lines.legs[k].set([foot, corners[k]]);
      this.#lines.legs[k].node.dataset.what = `Leg ${k + 1}: L${k + 1} = ${shortened(distance(foot, corners[k]), 8)}`;
    });
    [...base, ...corners].forEach((place, k) => put(this.#points[NAMES[k]], place));
    for (const name of NAMES) {
      const { rendNode } = this.#points[name];
      const isFree = FREE[this.#mode].includes(name);
      if (isFree) rendNode.ariaLabel = this.#mode === "design" ? spoken(name, geometry) : MOVES[name];
      rendNode.dataset.what = isFree ? `${rendNode.ariaLabel}: drag it` : FIXED[name] ?? `${name < "B" ? "Base" : "Platform"} point ${name}`;
    }
    this.#meet();
    this.#board.update();
    this.#write();
    this.#explain();
  }

  /** The lines of the legs to the point where they meet, of the pose that is nearest to a singular one, if it is near. */
  #meet() {
    const { lengths, l1, b1, alpha } = this.#shown ?? {};
    if (!lengths) return;
    const own = { l1: toNumber(l1), alpha_deg: alpha / DEGREES, theta1_deg: Math.atan2(b1[1], b1[0]) / DEGREES };
    const poses = [own, ...this.#others.map((pose) => ({ l1: toNumber(pose.l1), alpha_deg: Number(pose.alpha_deg), theta1_deg: Number(pose.theta1_deg) }))];
    const ways = poses.map((pose, k) => clearanceOf(lengths, pose) + (k > 0 ? 0.01 : 0)); // of two that merge the first
    const nearest = poses[ways.indexOf(Math.min(...ways))];
    this.#isSingular = Math.min(...ways) < NEAR;
    const { lines, meeting } = this.#isSingular ? meetingLines(lengths, nearest) : { lines: [], meeting: null };
    this.#lines.meeting.set(this.#seen(lines));
    [this.#meeting] = this.#seen([meeting]);
  }

  /** Names of points, away from the middle of their triangle; lengths beside legs, or in a corner; numbers. */
  #labels() {
    if (!this.#shown) return [];
    const { lengths, b1, alpha } = this.#shown;
    const ends = [basePoints(lengths), platformPoints(lengths, b1, alpha)].map((points) => this.#seen(points));
    const triangles = ends.map((points) => points.map((point) => pixel(this.#board, point)));
    const taken = triangles.flat();
    const free = (places, own) => places.find((place) => taken.every((other) => other === own || distance(place, other) > AWAY)) ?? places[0];
    const names = triangles.flatMap((points, k) => points.map((point, i) => {
      const out = Math.atan2(point[1] - middleOf(points)[1], point[0] - middleOf(points)[0]);
      const places = [0, 0.8, -0.8, 1.6, -1.6, 2.4, -2.4].map((turn) => [point[0] + AWAY * Math.cos(out + turn), point[1] + AWAY * Math.sin(out + turn)]);
      const place = free(places, point);
      taken.push(place);
      return symbol(NAMES[3 * k + i], about(place, "name"));
    }));
    const ghosts = [];
    this.#ghosts.forEach((points, k) => {
      const corners = points.map((point) => pixel(this.#board, point));
      const at = free([middleOf(corners), ...corners]);
      const name = this.#names[k] ?? "";
      const other = ghosts.find((ghost) => distance(ghost.at, at) < AWAY);
      if (other) other.name += `, ${name}`;
      else ghosts.push({ at, name });
    });
    taken.push(...ghosts.map(({ at }) => at));
    const [feet, corners] = triangles;
    const legs = feet.flatMap((foot, k) => {
      const corner = corners[k];
      const length = distance(ends[0][k], ends[1][k]);
      const span = distance(foot, corner);
      const normal = span < 1 ? [0, 1] : [(foot[1] - corner[1]) / span, (corner[0] - foot[0]) / span];
      const by = 36 * Math.abs(normal[0]) + 8 * Math.abs(normal[1]) + 4; // half the text, across the leg
      const places = [1, 1.3].flatMap((far) => [0.5, 0.35, 0.65, 0.22, 0.78].flatMap((share) => [far, -far].map((side) =>
        [0, 1].map((axis) => foot[axis] + share * (corner[axis] - foot[axis]) + side * by * normal[axis]))))
        .concat([3, 2, 1].map((row) => [44, this.#board.canvasHeight - 17 * row]));
      const isIn = ([x, y]) => x > 36 && y > 10 && x < this.#board.canvasWidth - 36 && y < this.#board.canvasHeight - 10;
      const at = places.find(([x, y]) => isIn([x, y]) && taken.every(([u, v]) => Math.abs(x - u) > 64 || Math.abs(y - v) > 16));
      if (!at) return [];
      taken.push(at);
      return [symbol(`L${k + 1} = ${shortened(length, 5)}`, about(at))];
    });
    const numbers = ghosts.map(({ at, name }) => shape("text", about(at), name));
    const [cx, cy] = this.#meeting ? pixel(this.#board, this.#meeting) : [];
    const meeting = this.#meeting ? [shape("circle", { class: "meeting-point", cx, cy, r: 4, "data-what": this.#lines.meeting.node.dataset.what })] : [];
    return [...meeting, ...numbers, ...legs, ...names];
  }

  #explain() {
    showLegend([
      { name: "legs", as: "line", text: "leg" },
      { name: "platform", text: "platform" },
      { name: "base", as: "line", text: "base" },
      { name: "orbit", as: "line", text: "circle of B1" },
      { name: "ghost", as: "line", text: "other poses", if: this.#ghosts.length > 0 },
      { name: "meeting", as: "line", text: "legs that meet: singular", if: this.#isSingular },
      { name: "candidate", as: "line", text: "better geometry", if: Boolean(this.#candidate) },
    ], "mechanism-marks");
  }
}

const FIXED = { A1: "Base point A1", B1: "Platform point B1, at the end of leg 1" };
const MOVES = {
  B1: "Platform point B1, moves along its circle",
  B2: "Platform point B2, turns the platform about B1",
  B3: "Platform point B3, turns the platform about B1",
};

const about = ([x, y], what = "leg-name") => ({ class: `${what} halo`, x, y: y + 4, "text-anchor": "middle" });

const middleOf = (points) => [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length);

/** Of each leg the line from its foot, by its end, to the point where all meet, with gaps; far lines where they are parallel. */
function meetingLines(lengths, pose) {
  const { b1, alpha } = placeOf(pose);
  const [feet, corners] = [basePoints(lengths), platformPoints(lengths, b1, alpha)];
  const meeting = meetingOf(feet, corners);
  const lines = feet.flatMap((foot, k) => {
    const way = [0, 1].map((axis) => corners[k][axis] - foot[axis]);
    const far = [-50, 50].map((share) => [0, 1].map((axis) => foot[axis] + share * way[axis]));
    const ends = meeting ? [foot, corners[k], meeting] : far;
    const along = ends.map((end) => [(end[0] - foot[0]) * way[0] + (end[1] - foot[1]) * way[1], end]).sort(([one], [other]) => one - other);
    return [along[0][1], along.at(-1)[1], null];
  });
  return { lines, meeting };
}

function orbitOf(b1, count) {
  const radius = Math.hypot(...b1);
  const turns = Array.from({ length: count + 1 }, (_, k) => (2 * k * Math.PI) / count);
  return turns.map((turn) => [radius * Math.cos(turn), radius * Math.sin(turn)]);
}

function spoken(name, geometry) {
  const triangle = name < "B" ? "base" : "platform";
  const given = { A2: ["a2x"], A3: ["a3x", "a3y"], B2: ["d1", "d2"], B3: ["d2", "d3"] }[name];
  const corner = geometry[triangle]?.points?.[Number(name[1]) - 1];
  const numbers = corner ? [`x = ${corner[0]}`, `y = ${corner[1]}`] : given.map((length) => `${length} = ${geometry[length]}`);
  return [`${name < "B" ? "Base" : "Platform"} point ${name}`, ...(corner || isSix(geometry) ? numbers : [])].join(", ");
}
