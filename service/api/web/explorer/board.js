/** A drawing board of JSXGraph, and lines on it whose colours are those of the style sheet. */

import JXG from "../jsxgraph/jsxgraphcore.mjs";
import { on, shape } from "./dom.js";

const ROOM = { left: 30, right: 30, top: 22, bottom: 22 };
const KEY_STEP = 6; // pixels that an arrow key moves a point
const [FAREST, NEAREST] = [0.05, 1e6]; // magnifications that the wheel reaches
const LEAST = 0.6; // the share of the room that a picture fills before the frame follows it

/** A board in an element that keeps proportions or, with `isFree`, does not. */
export function makeBoard(id, title, isFree = false) {
  const board = JXG.JSXGraph.initBoard(id, {
    boundingBox: [-1, 1, 1, -1],
    keepAspectRatio: !isFree,
    axis: false,
    showCopyright: false,
    showNavigation: false,
    showInfobox: false,
    title,
    resize: { enabled: false }, // `bindSize` does
    maxFrameRate: 1000, // browsers send moves once a picture; at fewer, the last move of a drag would be lost
    pan: { enabled: true, needTwoFingers: true, needShift: false },
    zoom: { enabled: true, wheel: false, needShift: false, pinch: true, pinchHorizontal: false, pinchVertical: false }, // a `Frame` takes the wheel
    keyboard: { enabled: true, dx: KEY_STEP, dy: KEY_STEP, panShift: true },
  });
  board.containerObj.role = "group"; // "region" would be one landmark too many
  return board;
}

/** What a board shows: all of `extent()`, which it follows until somebody chooses something else. */
export class Frame {
  #board;
  #extent;
  #options;
  #isFree = false; // whether somebody has chosen what is seen
  #isFitting = false;
  #whole = 1; // pixels of a unit where all is shown

  /** `onMove()` is told each time that something else is seen; `stretch` is that of `fit`. */
  constructor(board, extent, { room = ROOM, stretch = null, onMove }) {
    [this.#board, this.#extent, this.#options] = [board, extent, { room, stretch }];
    board.on("boundingbox", () => {
      this.#isFree ||= !this.#isFitting;
      onMove();
    });
    const { containerObj: container, renderer: { svgRoot } } = board;
    const observer = new ResizeObserver(() => {
      if (!container.isConnected) observer.disconnect();
      const { clientWidth: width, clientHeight: height } = container;
      if (!width || !height || (width === svgRoot.clientWidth && height === svgRoot.clientHeight)) return;
      board.resizeContainer(width, height, true, true);
      this.showAll();
    });
    observer.observe(container);
    on(container, "wheel", (event) => this.#turned(event), { passive: false });
  }

  /** Zooms about the pointer: by a third for a notch of a wheel, and smoothly on a touchpad, whose pinch comes with Ctrl. */
  #turned(event) {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : 33) * (event.ctrlKey ? 4 : 1);
    const factor = Math.exp(-Math.max(Math.min(pixels, 240), -240) / 350);
    const after = this.factor * factor;
    if (after > FAREST && after < NEAREST) scaleAbout(this.#board, this.#board.getUsrCoordsOfMouse(event), factor);
  }

  showAll() {
    this.#fitting(() => fit(this.#board, this.#extent(), this.#options));
    this.#isFree = false;
    this.#whole = this.#board.unitX;
  }

  /** How much the picture is magnified. */
  get factor() {
    return this.#board.unitX / this.#whole;
  }

  follow() {
    if (!this.#isFree && isAmiss(this.#board, this.#extent(), this.#options.room)) this.showAll();
  }

  /** Follows what a dragged point moves, by zooming out about the point: it stays under the pointer. */
  followAbout(point) {
    this.#fitting(() => makeRoom(this.#board, point, this.#extent(), this.#options.room));
  }

  #fitting(change) {
    this.#isFitting = true;
    change();
    this.#isFitting = false;
  }
}

/** A line through points, or the area within; `set` draws it, and gaps are points that are null. An update of the board does not. */
export function makeLine(board, cssClass, layer = 5, what = "") {
  const curve = board.create("curve", [[], []], { highlight: false, fixed: true, tabindex: null, transitionDuration: 0, cssClass, layer, fillColor: "none", clip: false, needsRegularUpdate: false });
  curve.rendNode.ariaHidden = true;
  if (what) curve.rendNode.dataset.what = what;
  return {
    node: curve.rendNode,
    set(points) {
      curve.dataX = points.map((point) => (point ? point[0] : NaN));
      curve.dataY = points.map((point) => (point ? point[1] : NaN));
      curve.fullUpdate();
    },
  };
}

/** A dot; what names it is written over the board. */
export function makePoint(board, { cssClass, size = 4, draggable = false, layer = 9, what = "" }) {
  const point = board.create("point", [0, 0], {
    name: "",
    size,
    layer,
    cssClass,
    highlightCssClass: cssClass,
    fixed: !draggable,
    highlight: draggable,
    highlightStrokeColor: "none",
    transitionDuration: 0,
    clip: false,
    tabindex: draggable ? 0 : null,
    withLabel: false,
  });
  if (what) point.rendNode.dataset.what = what;
  return point;
}

/** A text whose digits after letters are subscripts: L2, θ1. */
export function symbol(name, attributes) {
  const text = shape("text", attributes);
  name.split(/(?<=[A-Zθ])(\d)/).forEach((part, k) => {
    if (part) text.append(k % 2 ? shape("tspan", { class: "sub", dy: 3 }, part) : shape("tspan", k ? { dy: -3 } : {}, part));
  });
  return text;
}

/** What is written over a board, in pixels: `draw()` gives its shapes, each time or, with `key()`, when that changes. */
export function overlay(board, draw, key = null) {
  const group = shape("g", { class: "over" });
  board.renderer.svgRoot.append(group);
  let last = null;
  return () => {
    const now = key?.();
    if (key && now === last) return;
    last = now;
    group.replaceChildren(...draw());
  };
}

export function pixel(board, [x, y]) {
  return [board.origin.scrCoords[1] + x * board.unitX, board.origin.scrCoords[2] - y * board.unitY];
}

/** Puts a point at a place and draws it there; the board stays as it is. */
export function move(point, place) {
  put(point, place);
  point.fullUpdate();
}

/** Puts a point at a place without firing its events. */
export function put(point, [x, y]) {
  point.setPositionDirectly(JXG.COORDS_BY_USER, [x, y]);
}

/**
 * Shows the rectangle that holds all points, with room at its sides in pixels; what has no extent gets some.
 * Proportions are kept, or, with `stretch`, the board is filled if the scales differ by more.
 */
export function fit(board, points, { room = ROOM, stretch = null } = {}) {
  const known = points.filter((point) => point?.every(Number.isFinite));
  if (known.length === 0) return;
  const across = extent(known.map(([x]) => x), board.canvasWidth, room.left, room.right);
  const upward = extent(known.map(([, y]) => y), board.canvasHeight, room.bottom, room.top);
  const [least, most] = [across.unit, upward.unit].sort((a, b) => a - b);
  const unit = stretch === null || (most <= stretch * least && stretch < Infinity) ? most : null;
  const [left, right] = ends(across, unit);
  const [low, high] = ends(upward, unit);
  board.setBoundingBox([left, high, right, low], board.keepaspectratio);
}

/** Whether the points leave the room of a board, or fill little of it. */
function isAmiss(board, points, room) {
  const places = points.filter((point) => point?.every(Number.isFinite)).map((point) => pixel(board, point));
  if (places.length === 0) return false;
  const [width, height] = [board.canvasWidth, board.canvasHeight];
  const spans = [[room.left, width - room.right], [room.top, height - room.bottom]];
  const shares = spans.map(([low, high], k) => {
    const values = places.map((place) => place[k]);
    const [least, most] = [Math.min(...values), Math.max(...values)];
    return least < low - 12 || most > high + 12 ? Infinity : (most - least) / (high - low);
  });
  return Math.max(...shares) === Infinity || Math.max(...shares) < LEAST;
}

function extent(values, pixels, before, after) {
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (low === high) [low, high] = [low - Math.abs(low || 1) / 10, high + Math.abs(high || 1) / 10];
  return { low, high, before, after, pixels, unit: (high - low) / Math.max(pixels - before - after, 1) };
}

/** The ends of an axis with that length of a pixel, or its own. */
function ends({ low, high, before, after, pixels, unit: own }, unit) {
  const length = unit ?? own;
  const spare = (pixels * length - (high - low) - (before + after) * length) / 2;
  return [low - before * length - spare, high + after * length + spare];
}

/** Zooms out about the place of a point until all others have room too, as far as its own side lets them. */
function makeRoom(board, point, points, room) {
  const [x, y] = pixel(board, point);
  const ends = [[room.left, board.canvasWidth - room.right], [room.top, board.canvasHeight - room.bottom]];
  const shares = points.map((other) => pixel(board, other)).flatMap((place) => [x, y].map((at, k) => {
    const [low, high] = ends[k];
    const way = place[k] - at;
    const free = way > 0 ? high - at : at - low;
    return free > 0 && Math.abs(way) > free ? free / Math.abs(way) : 1;
  }));
  const factor = Math.max(Math.min(...shares), 0.5);
  if (factor < 1) scaleAbout(board, point, factor);
}

/** Zooms about a point, which stays where it is. */
function scaleAbout(board, [u, v], factor) {
  const [left, top, right, bottom] = board.getBoundingBox();
  board.setBoundingBox([u + (left - u) / factor, v + (top - v) / factor, u + (right - u) / factor, v + (bottom - v) / factor], board.keepaspectratio);
}

export function zoomAbout(board, [x, y], factor) {
  const [left, high, right, low] = board.getBoundingBox();
  const [wide, tall] = [(right - left) / factor / 2, (high - low) / factor / 2];
  board.setBoundingBox([x - wide, y + tall, x + wide, y - tall], board.keepaspectratio);
}
