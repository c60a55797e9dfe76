/** Arcs of circles and conics in doubles, as points of lines that are drawn. */

const TURN = 2 * Math.PI;
const STEP = TURN / 120; // of an arc of a circle
const DEPTH = 5; // halvings of an arc of a conic
const CELLS = 72; // of the grid, in each direction, on which a conic is drawn

/**
 * The points of an arc of a boundary, whose ends are vertices by their numbers from 1: of the circle, or else of the conic
 * `{kind, coefficients}` with a·x² + b·xy + c·y² + d·x + e·y + f = 0.
 */
export function arcOf({ from, to, ccw, through }, vertices, circle, { kind, coefficients }) {
  const ends = from === null ? null : [vertices[from - 1], vertices[to - 1]];
  if (circle) return ofCircle(circle, ends, ccw);
  if (!ends) return ofEllipse(coefficients);
  if (kind.includes("line")) return ends;
  const middle = [Number(through.x), Number(through.y)];
  const [one, other] = ends.map((end, k) => halved(coefficients, k === 0 ? [end, middle] : [middle, end], ends[1 - k], DEPTH));
  return [...one, ...other, ends[1]];
}

function ofCircle({ centre, radius }, ends, isLeft) {
  const [start, stop] = (ends ?? [[centre[0] + radius, centre[1]], [centre[0] + radius, centre[1]]]).map(([x, y]) => Math.atan2(y - centre[1], x - centre[0]));
  const way = (isLeft ? 1 : -1) * (stop - start);
  const sweep = (((way % TURN) + TURN) % TURN || TURN) * (isLeft ? 1 : -1);
  const count = Math.ceil(Math.abs(sweep) / STEP) + 1;
  return Array.from({ length: count + 1 }, (_, k) => start + (sweep * k) / count).map((angle) => [centre[0] + radius * Math.cos(angle), centre[1] + radius * Math.sin(angle)]);
}

function ofEllipse([a, b, c, d, e, f]) {
  const determinant = 4 * a * c - b * b;
  const [x, y] = [(b * e - 2 * c * d) / determinant, (b * d - 2 * a * e) / determinant];
  const rest = a * x * x + b * x * y + c * y * y + d * x + e * y + f;
  return Array.from({ length: 121 }, (_, k) => (k * TURN) / 120).map((angle) => {
    const [u, v] = [Math.cos(angle), Math.sin(angle)];
    const reach = Math.sqrt(Math.max(-rest / (a * u * u + b * u * v + c * v * v), 0));
    return [x + reach * u, y + reach * v];
  });
}

/**
 * Points from the first of two to before the second. A branch of a conic is convex, so that its arc lies on the other side
 * of their chord than a third point of it: where the normal in the middle of the chord meets it first there.
 */
function halved(coefficients, [first, last], beyond, depth) {
  const [a, b, c, d, e, f] = coefficients;
  const [x, y] = [0, 1].map((axis) => (first[axis] + last[axis]) / 2);
  let [u, v] = [first[1] - last[1], last[0] - first[0]];
  if (u * (beyond[0] - x) + v * (beyond[1] - y) > 0) [u, v] = [-u, -v];
  const square = a * u * u + b * u * v + c * v * v;
  const linear = 2 * a * x * u + b * (x * v + y * u) + 2 * c * y * v + d * u + e * v;
  const rest = a * x * x + b * x * y + c * y * y + d * x + e * y + f;
  const root = Math.sqrt(linear * linear - 4 * square * rest);
  const signed = -(linear + Math.sign(linear || 1) * root) / 2;
  const ways = [signed / square, rest / signed].filter((way) => way >= 0);
  if (depth === 0 || ways.length === 0) return [first];
  const between = [x + Math.min(...ways) * u, y + Math.min(...ways) * v];
  return [...halved(coefficients, [first, between], last, depth - 1), ...halved(coefficients, [between, last], first, depth - 1)];
}

/** Segments of a conic in a square `{left, top, size}`: of each cell of a grid the line between the sides that it crosses. */
export function contourOf([a, b, c, d, e, f], { left, top, size }) {
  const at = (k, j) => [left + (k * size) / CELLS, top - (j * size) / CELLS];
  const value = ([x, y]) => a * x * x + b * x * y + c * y * y + d * x + e * y + f;
  const segments = [];
  for (let k = 0; k < CELLS; k += 1) {
    for (let j = 0; j < CELLS; j += 1) {
      const corners = [at(k, j), at(k + 1, j), at(k + 1, j + 1), at(k, j + 1)];
      const values = corners.map(value);
      const crossed = corners.flatMap((corner, i) => {
        const [next, one, other] = [corners[(i + 1) % 4], values[i], values[(i + 1) % 4]];
        if (one > 0 === other > 0) return [];
        return [[0, 1].map((axis) => corner[axis] + (one / (one - other)) * (next[axis] - corner[axis]))];
      });
      for (let i = 0; i + 1 < crossed.length; i += 2) segments.push([crossed[i], crossed[i + 1]]);
    }
  }
  return segments;
}
