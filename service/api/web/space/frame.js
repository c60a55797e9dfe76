/** The box round the joint space: the walls behind what is seen, ticks and names of the axes. */

import { ticksOf, tickText } from "../explorer/axes.js";

const [NUMBER, NAME] = [13, 33]; // pixels from an edge of the box to its numbers, and to its name
const APART = 26; // pixels between numbers

/** The lines of the walls, `[[L1, L2, L3], [L1, L2, L3]]`, with a key that changes when they do, and the texts of the axes: `{text, x, y, isName}`. */
export function frameOf(camera, { low, high }, size) {
  const [, , eye] = camera.axes;
  const ends = [low, high];
  const far = eye.map((toEye) => (toEye > 0 ? 0 : 1)); // the end of each axis at which its wall is
  const matrix = camera.matrix;
  const seen = (place) => camera.project(place, matrix);
  const lines = [];
  const texts = [];
  const [cx, cy] = seen(low.map((x, k) => (x + high[k]) / 2));
  const ticks = low.map((from, k) => ticksOf(from, high[k], 5).filter((x) => x > from + 1e-9 && x < high[k] - 1e-9));
  [0, 1, 2].forEach((axis) => {
    const others = [0, 1, 2].filter((other) => other !== axis);
    const at = (value, k, m) => others.reduce((place, other, i) => place.with(other, ends[[k, m][i]][other]), [0, 0, 0]).with(axis, value);
    const [a, b] = others.map((other) => far[other]);
    for (const value of [low[axis], ...ticks[axis], high[axis]]) lines.push([at(value, a, b), at(value, 1 - a, b)], [at(value, a, b), at(value, a, 1 - b)]);
    const edges = [[a, 1 - b], [1 - a, b]].map(([k, m]) => ({ k, m, from: seen(at(low[axis], k, m)), to: seen(at(high[axis], k, m)) }));
    const side = axis === 0 ? ({ from, to }) => from[0] + to[0] : ({ from, to }) => -from[1] - to[1];
    const { k, m, from, to } = edges.sort((one, other) => side(one) - side(other))[0]; // the left one upwards, else the lower one
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (length < APART) return;
    const [mx, my] = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
    let out = [(to[1] - from[1]) / length, (from[0] - to[0]) / length];
    if (out[0] * (mx - cx) + out[1] * (my - cy) < 0) out = out.map((x) => -x);
    let last = null;
    for (const value of ticks[axis]) {
      const [x, y] = seen(at(value, k, m));
      if (last && Math.hypot(x - last[0], y - last[1]) < APART) continue;
      last = [x, y];
      texts.push({ text: tickText(value, false), x: x + NUMBER * out[0], y: y + NUMBER * out[1], isName: false });
    }
    const top = from[1] < to[1] ? from : to;
    const place = axis === 0 ? { x: top[0], y: top[1] - NUMBER } : { x: mx + NAME * out[0], y: my + NAME * out[1] };
    const within = ["x", "y"].map((name, i) => Math.min(Math.max(place[name], 10), size[i] - 10));
    texts.push({ text: `L${axis + 1}`, x: within[0], y: within[1], isName: true });
  });
  return { key: [...far, ...low, ...high].join(), lines, texts };
}
