/** What is seen of the joint space where there is no WebGL: lines on a canvas, the surface by its contours. */

const FAINT = 0.42; // of what is before the slice

export class CanvasDrawing {
  isSoftware = true;
  #canvas;
  #context;
  #size = [1, 1];
  #density = 1;
  #bold = 1;
  #colours = null;
  #lines = new Map();
  #marks = [];
  #areas = [];
  #mesh = null;
  #contours = { key: "", levels: [] };

  constructor(canvas) {
    [this.#canvas, this.#context] = [canvas, canvas.getContext("2d")];
  }

  resize(width, height, density, bold) {
    [this.#canvas.width, this.#canvas.height] = [Math.round(width * density), Math.round(height * density)];
    [this.#size, this.#density, this.#bold] = [[width, height], density, bold];
  }

  colours(colours) {
    this.#colours = colours;
  }

  surface(mesh) {
    this.#mesh = mesh;
    this.#contours.key = "";
  }

  lines(name, list, { isBehind = false } = {}) {
    this.#lines.set(name, { list, isBehind });
  }

  marks(list) {
    this.#marks = list;
  }

  plane(areas) {
    this.#areas = areas;
  }

  render(camera, { axis, level, spacing }) {
    const [context, matrix] = [this.#context, camera.matrix];
    const seen = (place) => camera.project(place, matrix);
    context.setTransform(this.#density, 0, 0, this.#density, 0, 0);
    context.clearRect(0, 0, ...this.#size);
    context.lineJoin = context.lineCap = "round";
    this.#stroke(seen, true);
    if (this.#mesh) this.#cut(axis, spacing / 2);
    const side = camera.axes[2][axis] > 0 ? 1 : -1; // on which the eye is
    const isBefore = (height) => level !== null && side * (height - level) > 0;
    for (const contour of this.#contours.levels) if (!isBefore(contour.height)) this.#contour(contour, seen, 1);
    for (const { rings, colour, alpha } of this.#areas) {
      context.beginPath();
      for (const ring of rings) {
        ring.forEach((place, k) => context[k ? "lineTo" : "moveTo"](...seen(place).slice(0, 2)));
        context.closePath();
      }
      context.fillStyle = css(colour, alpha);
      context.fill("evenodd");
    }
    for (const contour of this.#contours.levels) if (isBefore(contour.height)) this.#contour(contour, seen, FAINT);
    this.#stroke(seen, false);
    for (const mark of this.#marks) this.#mark(mark, seen(mark.place));
  }

  #stroke(seen, isBehind) {
    for (const entry of this.#lines.values()) {
      if (entry.isBehind !== isBehind) continue;
      for (const { points, colour, width } of entry.list) {
        this.#context.beginPath();
        points.forEach((place, k) => this.#context[k ? "lineTo" : "moveTo"](...seen(place).slice(0, 2)));
        this.#context.strokeStyle = css(colour, 1);
        this.#context.lineWidth = width * this.#bold;
        this.#context.stroke();
      }
    }
  }

  #contour({ segments }, seen, alpha) {
    const context = this.#context;
    context.beginPath();
    for (let k = 0; k < segments.length; k += 6) {
      const [x, y] = seen(segments.slice(k, k + 3));
      const [u, v] = seen(segments.slice(k + 3, k + 6));
      context.moveTo(x, y);
      context.lineTo(u, v);
    }
    context.strokeStyle = css(this.#colours.fewer, alpha);
    context.lineWidth = 0.8;
    context.stroke();
  }

  /** Cuts the surface by the planes across an axis at the multiples of a length. */
  #cut(axis, spacing) {
    const key = [axis, spacing].join();
    if (this.#contours.key === key) return;
    const { positions, index } = this.#mesh;
    const levels = new Map();
    for (let t = 0; t < index.length; t += 3) {
      const corners = [0, 1, 2].map((k) => 3 * index[t + k]);
      const heights = corners.map((k) => positions[k + axis] / spacing);
      for (let n = Math.ceil(Math.min(...heights)); n <= Math.max(...heights); n += 1) {
        const ends = [0, 1, 2].flatMap((k) => {
          const [p, q] = [heights[k] - n, heights[(k + 1) % 3] - n];
          if (p > 0 === q > 0) return [];
          return [[0, 1, 2].map((i) => positions[corners[k] + i] + (p / (p - q)) * (positions[corners[(k + 1) % 3] + i] - positions[corners[k] + i]))];
        });
        if (ends.length !== 2) continue;
        if (!levels.has(n)) levels.set(n, []);
        levels.get(n).push(...ends.flat());
      }
    }
    this.#contours = { key, levels: [...levels].map(([n, segments]) => ({ height: n * spacing, segments })) };
  }

  #mark({ colour, form, size }, [x, y]) {
    const context = this.#context;
    const r = (size / 2) * this.#bold;
    const polygon = [null, [[0, -1.15], [1.15, 0], [0, 1.15], [-1.15, 0]], [[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]], [[-1, 0.6], [1, 0.6], [0, -1.1]]][form];
    context.beginPath();
    if (polygon) polygon.forEach(([u, v], k) => context[k ? "lineTo" : "moveTo"](x + r * u, y + r * v));
    else context.arc(x, y, r, 0, 7);
    context.closePath();
    context.fillStyle = css(form === 0 ? this.#colours.paper : colour, 1);
    context.strokeStyle = css(form === 0 ? colour : this.#colours.paper, 1);
    context.lineWidth = form === 0 ? 2 : 1;
    context.fill();
    context.stroke();
  }
}

const css = (colour, alpha) => `rgb(${colour.map((x) => Math.round(255 * x)).join(" ")} / ${alpha})`;
