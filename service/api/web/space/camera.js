/**
 * From where (L1, L2, L3) is seen: a point that it turns round, two angles and a magnification. L1 points upwards, L2 to
 * the right and L3 away.
 */

const DEGREES = Math.PI / 180;
export const FAR = 6; // of the eye, over half the diagonal of the box
const DEEP = 0.3; // of depths
const MARGINS = [34, 26]; // pixels beside and above, where the axes have their numbers
const CLOSER = 1.05; // by which what is near looks larger
const STEEPEST = 89;
const [LEAST, MOST] = [0.3, 400]; // magnification
export const START = { yaw: -37, pitch: 22 };

export class Camera {
  yaw = START.yaw;
  pitch = START.pitch;
  zoom = 1;
  target = [0, 0, 0]; // from the middle of the box, over half of its diagonal
  #middle = [0, 0, 0];
  #half = 1;
  #reach = [1, 1]; // of the box sideways, and upwards, over half its diagonal
  #size = [1, 1];

  /** Takes the corners of the box, (L1, L2, L3). */
  frame(low, high) {
    this.#middle = low.map((x, k) => (x + high[k]) / 2);
    const [tall, ...wide] = low.map((x, k) => (high[k] - x) / 2);
    this.#half = Math.hypot(tall, ...wide) || 1;
    this.#reach = [Math.hypot(...wide) / this.#half, tall / this.#half];
  }

  resize(width, height) {
    this.#size = [Math.max(width, 1), Math.max(height, 1)];
  }

  showAll() {
    Object.assign(this, { ...START, zoom: 1, target: [0, 0, 0] });
  }

  /** The directions to the right, upwards and to the eye, in (L1, L2, L3). */
  get axes() {
    const [c, s, p, q] = [Math.cos(this.yaw * DEGREES), Math.sin(this.yaw * DEGREES), Math.cos(this.pitch * DEGREES), Math.sin(this.pitch * DEGREES)];
    return [[0, c, s], [p, -s * q, c * q], [q, s * p, -c * p]];
  }

  /** Pixels of half the diagonal of the box: it has room however it is turned sideways. */
  get scale() {
    const [wide, tall] = this.#reach;
    const pitch = Math.abs(this.pitch) * DEGREES;
    const needs = [wide, tall * Math.cos(pitch) + wide * Math.sin(pitch)];
    return (Math.min(...this.#size.map((pixels, k) => Math.max(pixels - 2 * MARGINS[k], pixels / 2) / (2 * needs[k]))) / CLOSER) * this.zoom;
  }

  /** Pixels of a unit of length, in the middle. */
  get unit() {
    return this.scale / this.#half;
  }

  /** Takes (L1, L2, L3) to clip coordinates, by columns. */
  get matrix() {
    const [right, up, eye] = this.axes;
    const [x, y] = this.#size.map((pixels) => (2 * this.scale) / pixels);
    const rows = [right.map((a) => a * x), up.map((a) => a * y), eye.map((a) => -a * DEEP), eye.map((a) => -a / FAR)].map((row) => row.map((a) => a / this.#half));
    const centre = this.#middle.map((m, k) => m + this.target[k] * this.#half);
    const offsets = rows.map((row) => -row.reduce((sum, a, k) => sum + a * centre[k], 0));
    offsets[3] += 1;
    return [0, 1, 2].flatMap((column) => rows.map((row) => row[column])).concat(offsets);
  }

  /** The place of (L1, L2, L3) in pixels, and its depth from −1 to 1. */
  project([x, y, z], m = this.matrix) {
    const [a, b, c, w] = [0, 1, 2, 3].map((row) => m[row] * x + m[row + 4] * y + m[row + 8] * z + m[row + 12]);
    return [(this.#size[0] / 2) * (1 + a / w), (this.#size[1] / 2) * (1 - b / w), c / w];
  }

  turn(yaw, pitch) {
    this.yaw = (this.yaw + yaw) % 360;
    this.pitch = Math.min(Math.max(this.pitch + pitch, -STEEPEST), STEEPEST);
  }

  /** Moves what is seen by pixels. */
  pan(x, y) {
    const [right, up] = this.axes;
    this.target = this.target.map((t, k) => Math.min(Math.max(t + (-x * right[k] + y * up[k]) / this.scale, -1), 1));
  }

  /** Magnifies about a place in pixels. */
  zoomAbout(factor, x = this.#size[0] / 2, y = this.#size[1] / 2) {
    const before = this.zoom;
    this.zoom = Math.min(Math.max(before * factor, LEAST), MOST);
    const by = 1 - before / this.zoom;
    this.pan(-by * (x - this.#size[0] / 2) * (this.zoom / before), -by * (y - this.#size[1] / 2) * (this.zoom / before));
  }

  /** Puts (L1, L2, L3) in the middle. */
  look(place) {
    this.target = place.map((x, k) => (x - this.#middle[k]) / this.#half);
  }

  /** The view as a text for links: angles, and where it is magnified also by how much and about which point. */
  get text() {
    const rest = this.zoom === 1 && this.target.every((x) => x === 0) ? [] : [this.zoom, ...this.target].map((x) => Number(x.toPrecision(4)));
    return [Math.round(this.yaw), Math.round(this.pitch), ...rest].join(",");
  }

  /** Takes what `text` gave; anything else is no harm. */
  take(text) {
    const [yaw, pitch, zoom = 1, ...target] = (text ?? "").split(",").map(Number);
    if (!Number.isFinite(yaw + pitch)) return this.showAll();
    Object.assign(this, { yaw, pitch: Math.min(Math.max(pitch, -STEEPEST), STEEPEST), zoom: 1, target: [0, 0, 0] });
    if (zoom > 0) this.zoom = Math.min(Math.max(zoom, LEAST), MOST);
    if (target.length === 3 && target.every((x) => Math.abs(x) <= 1)) this.target = target;
  }
}
