/** A drawing board of JSXGraph, and lines on it whose colours are those of the style sheet. */

import JXG from "../jsxgraph/jsxgraphcore.mjs";

export const PLAIN = { highlight: false, fixed: true, tabindex: null, transitionDuration: 0 };
const ROOM = { left: 26, right: 26, top: 22, bottom: 22 };
export const ROOM_FOR_AXES = { left: 58, right: 24, top: 18, bottom: 40 };
const ZOOM = 1.6;
const KEY_STEP = 6; // pixels that an arrow key moves a point

JXG.Options.text.display = "internal"; // SVG text: HTML over the drawing would need inline styles

/** A board in an element; `axes` are the names of its axes, a board without them keeps proportions. */
export function makeBoard(id, title, axes = null) {
  const board = JXG.JSXGraph.initBoard(id, {
    boundingBox: [-1, 1, 1, -1],
    keepAspectRatio: !axes,
    axis: false,
    showCopyright: false,
    showNavigation: false,
    showInfobox: false,
    title,
    pan: { enabled: true, needTwoFingers: true, needShift: false },
    zoom: { enabled: true, wheel: true, needShift: true, pinch: true },
    keyboard: { enabled: true, dx: KEY_STEP, dy: KEY_STEP, panShift: true },
  });
  board.containerObj.setAttribute("role", "group"); // "region" would be one landmark too many
  if (axes) axes.forEach((name, k) => makeAxis(board, name, k));
  return board;
}

function makeAxis(board, name, k) {
  const end = k === 0 ? [1, 0] : [0, 1];
  board.create("axis", [[0, 0], end], {
    ...PLAIN,
    name,
    withLabel: true,
    cssClass: "axis",
    position: "fixed",
    anchor: k === 0 ? "right" : "left",
    anchorDist: () => (k === 0 ? `${26 / board.canvasHeight}fr` : `${44 / board.canvasWidth}fr`),
    lastArrow: false,
    label: { ...PLAIN, cssClass: "axis-name", position: k === 0 ? "rt" : "rt", offset: k === 0 ? [-26, 12] : [8, -10] },
    ticks: {
      ...PLAIN,
      cssClass: "tick",
      drawZero: true,
      minorTicks: 0,
      majorHeight: 6,
      majorTickEndings: [1, 1],
      ticksPerLabel: 1,
      insertTicks: true,
      generateLabelText: (tick, zero) => tickText(tick.usrCoords[k + 1] - zero.usrCoords[k + 1]),
      minTicksDistance: k === 0 ? 60 : 40,
      label: {
        ...PLAIN,
        cssClass: "tick-label",
        fontSize: 11,
        anchorX: k === 0 ? "middle" : "right",
        anchorY: k === 0 ? "top" : "middle",
        offset: k === 0 ? [0, -6] : [-7, 0],
      },
    },
  });
}

/** A number on an axis: short, also if it is large or small. */
function tickText(value) {
  const rounded = Number(value.toPrecision(6));
  const size = Math.abs(rounded);
  const text = size === 0 || (size >= 1e-3 && size < 1e5) ? String(rounded) : rounded.toExponential();
  return text.replaceAll("-", "−").replace("e+", "e");
}

/** A line through points, or the area within; `set` moves it, and gaps are points that are null. */
export function makeLine(board, cssClass, layer = 5) {
  const curve = board.create("curve", [[], []], { ...PLAIN, cssClass, layer, fillColor: "none", clip: false });
  curve.rendNode.setAttribute("aria-hidden", "true");
  return {
    node: curve.rendNode,
    set(points) {
      curve.dataX = points.map((point) => (point ? point[0] : NaN));
      curve.dataY = points.map((point) => (point ? point[1] : NaN));
      curve.needsUpdate = true;
    },
  };
}

/** A dot with its name beside it. */
export function makePoint(board, name, { cssClass, size = 4, draggable = false, label = [8, 8], layer = 9 }) {
  return board.create("point", [0, 0], {
    name,
    size,
    layer,
    cssClass,
    highlightCssClass: cssClass,
    fixed: !draggable,
    highlight: draggable,
    highlightStrokeColor: "none",
    showInfobox: false,
    transitionDuration: 0,
    clip: false,
    tabindex: draggable ? 0 : null,
    withLabel: Boolean(name),
    label: { ...PLAIN, cssClass: "point-name", offset: label, fontSize: 13, autoPosition: false },
  });
}

/** Puts a point at a place without firing its events. */
export function put(point, [x, y]) {
  point.setPositionDirectly(JXG.COORDS_BY_USER, [x, y]);
}

/** Shows the rectangle that holds all points, with room at its sides in pixels; what has no extent gets some. */
export function fit(board, points, { room = ROOM, keepAspect = false } = {}) {
  const known = points.filter((point) => point && point.every(Number.isFinite));
  if (known.length === 0) return;
  const across = extent(known.map(([x]) => x), board.canvasWidth, room.left, room.right);
  const upward = extent(known.map(([, y]) => y), board.canvasHeight, room.bottom, room.top);
  const unit = keepAspect ? Math.max(across.unit, upward.unit) : null;
  const [left, right] = ends(across, unit);
  const [low, high] = ends(upward, unit);
  board.setBoundingBox([left, high, right, low], keepAspect);
}

/** The interval of the values, and the length of a pixel that shows it with room at both sides. */
function extent(values, pixels, before, after) {
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (low === high) [low, high] = [low - Math.abs(low || 1) / 10, high + Math.abs(high || 1) / 10];
  return { low, high, before, after, pixels, unit: (high - low) / Math.max(pixels - before - after, 1) };
}

/** The ends of an axis with that length of a pixel, or its own; what is left over is shared by both sides. */
function ends({ low, high, before, after, pixels, unit: own }, unit) {
  const length = unit ?? own;
  const spare = (pixels * length - (high - low) - (before + after) * length) / 2;
  return [low - before * length - spare, high + after * length + spare];
}

/** Buttons that zoom about a place, or show all again. */
export function bindZoom(toolbar, { zoom, showAll }) {
  const actions = { in: () => zoom(ZOOM), out: () => zoom(1 / ZOOM), all: showAll };
  for (const button of toolbar.querySelectorAll("button[data-zoom]")) {
    button.addEventListener("click", actions[button.dataset.zoom]);
  }
}

/** Magnifies a board; what is at the place comes to the middle. */
export function zoomAbout(board, [x, y], factor) {
  const [left, high, right, low] = board.getBoundingBox();
  const [wide, tall] = [(right - left) / factor / 2, (high - low) / factor / 2];
  board.setBoundingBox([x - wide, y + tall, x + wide, y - tall], board.keepaspectratio);
}
