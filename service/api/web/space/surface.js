/**
 * The singular surface of a manipulator as a mesh: J = 0 on a grid of α, θ and the length of the fixed leg, mapped to the
 * lengths of all legs. It has sides along its cusp curves and where legs close, and is finer where chords would leave it.
 */

import { Legs } from "./legs.js";

export const GRID = [64, 64, 48]; // cells of α, θ and the length
const SHIFT = 0.37; // of the grid by a cell: symmetric machines are singular at round angles
const ROOTS = 3; // steps to a zero of J on a side of a cell
const PASSES = 3;
const [INNER, CUSP, FIRST, SECOND] = [0, 1, 2, 3]; // kinds of vertices: on a cusp curve, or where a free leg closes
const FINE = 0.001; // how far chords may leave the surface, over the size of the box
const TURN = 2 * Math.PI;
const FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]; // corners of a cell, in turn; bits are axes

/**
 * The mesh for lengths of the fixed leg from 0 to `reach`:
 * `{positions, normals, index, low, high}`; each vertex has its place (L1, L2, L3) and its normal, which points to where
 * there are two poses more, and all lies between the corners `low` and `high`.
 */
export function surfaceOf(triangles, leg, reach, grid = GRID) {
  const mesh = new Mesh(new Legs(triangles, leg), reach);
  mesh.march(grid);
  mesh.cut();
  mesh.refine();
  return mesh.finish();
}

class Mesh {
  #legs;
  #reach;
  #poses = []; // α, θ, L of each vertex, one after another
  #places = []; // L1, L2, L3
  #normals = [];
  #kernels = []; // dα, dθ, and the slope of J along it
  #ends = []; // of the free legs
  #kinds = []; // INNER, CUSP, FIRST or SECOND
  #triangles = [];

  constructor(legs, reach) {
    [this.#legs, this.#reach] = [legs, reach];
  }

  /** Adds the pose that the legs have looked at. */
  #add(kind = INNER) {
    const { ends, alpha, theta, length, kernel, jAlpha, jTheta } = this.#legs;
    this.#poses.push(alpha, theta, length);
    this.#places.push(...this.#legs.joints);
    this.#normals.push(...this.#legs.normal);
    this.#kernels.push(...kernel, kernel[0] * jAlpha + kernel[1] * jTheta);
    this.#ends.push(...ends);
    return this.#kinds.push(kind) - 1;
  }

  /** Marching cubes: the sides of a cell on which J changes its sign are joined across its faces. */
  march([across, upward, tall]) {
    const legs = this.#legs;
    const [da, dt, dl] = [TURN / across, TURN / upward, this.#reach / tall];
    const columns = across * upward;
    const values = new Float64Array(columns * (tall + 1));
    for (let j = 0; j < upward; j += 1) {
      for (let i = 0; i < across; i += 1) {
        legs.line((i + SHIFT) * da, (j + SHIFT) * dt);
        for (let k = 0; k <= tall; k += 1) values[k * columns + j * across + i] = legs.start + legs.rise * k * dl;
      }
    }
    const known = new Int32Array(3 * values.length).fill(-1); // vertices, by the lower end and the axis of a side
    const place = (i, j, k) => k * columns + (j === upward ? 0 : j) * across + (i === across ? 0 : i);
    const vertex = (i, j, k, one, other) => {
      const [from, way] = [one & other, one ^ other];
      const [axis, x, y, z] = [way >> 1, i + (from & 1), j + ((from >> 1) & 1), k + (from >> 2)];
      const [low, high] = [place(x, y, z), place(x + (way & 1), y + ((way >> 1) & 1), z + (way >> 2))];
      const name = 3 * low + axis;
      if (known[name] >= 0) return known[name];
      const [alpha, theta, length] = [(x + SHIFT) * da, (y + SHIFT) * dt, z * dl];
      const share = axis === 2 ? values[low] / (values[low] - values[high]) : zeroOf((part) => {
        legs.line(alpha + (axis === 0 ? part * da : 0), theta + (axis === 1 ? part * dt : 0));
        return legs.start + legs.rise * length;
      }, values[low], values[high]);
      legs.at(alpha + (axis === 0 ? share * da : 0), theta + (axis === 1 ? share * dt : 0), axis === 2 ? length + share * dl : length);
      return (known[name] = this.#add());
    };
    for (let k = 0; k < tall; k += 1) {
      for (let j = 0; j < upward; j += 1) {
        for (let i = 0; i < across; i += 1) {
          let mask = 0;
          for (let corner = 0; corner < 8; corner += 1) {
            if (values[place(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2))] > 0) mask |= 1 << corner;
          }
          if (mask === 0 || mask === 255) continue;
          for (const loop of loopsOf(mask)) {
            const corners = loop.map(([one, other]) => vertex(i, j, k, one, other));
            for (let n = 2; n < corners.length; n += 1) this.#triangles.push(corners[0], corners[n - 1], corners[n]);
          }
        }
      }
    }
  }

  /** Puts vertices where sides cross the cusp curves, and where legs close. */
  cut() {
    const kernels = this.#kernels;
    this.#split((p, q) => {
      const closed = this.#closing(p, q);
      if (closed) return this.#added(closed.kind, this.#between(p, q, closed.share), this.#isHeld(p, q), true);
      const [u, v, c, x, y, d] = [kernels[3 * p], kernels[3 * p + 1], kernels[3 * p + 2], kernels[3 * q], kernels[3 * q + 1], kernels[3 * q + 2]];
      const other = u * x + v * y < 0 ? -d : d; // along the same way
      return c * other < 0 ? this.#added(CUSP, this.#between(p, q, c / (c - other)), this.#isHeld(p, q), true) : -1;
    });
  }

  /** Which free leg closes on a side, and where; null if none does. */
  #closing(p, q) {
    const ends = this.#ends;
    for (const [kind, at] of [[FIRST, 0], [SECOND, 2]]) {
      const [x, y, u, v] = [ends[4 * p + at], ends[4 * p + at + 1], ends[4 * q + at], ends[4 * q + at + 1]];
      const away = Math.abs(x * v - y * u); // of the side from the base point, times its length
      if (x * u + y * v < 0 && away < 0.2 * ((x - u) ** 2 + (y - v) ** 2)) return { kind, share: Math.hypot(x, y) / (Math.hypot(x, y) + Math.hypot(u, v)) };
    }
    return null;
  }

  /** Adds the vertex of a kind that is nearest to a pose; or if none is, nothing, or one on the surface. */
  #added(kind, pose, isHeld, isStrict = false) {
    const legs = this.#legs;
    const isFound = kind === INNER ? false : kind === CUSP ? legs.ontoEdge(...pose, isHeld) : legs.ontoClosed(kind === SECOND, ...pose, isHeld);
    if (!isFound && isStrict) return -1;
    if (!isFound) legs.ontoSurface(...pose, isHeld);
    return legs.length >= 0 && legs.length <= this.#reach ? this.#add(isFound ? kind : INNER) : -1;
  }

  /** Halves sides that leave the surface, some times. */
  refine() {
    const [legs, places, normals, kinds, most] = [this.#legs, this.#places, this.#normals, this.#kinds, FINE * this.#size()];
    for (let pass = 0; pass < PASSES; pass += 1) {
      const count = kinds.length;
      this.#split((p, q) => {
        const kind = kinds[p] === kinds[q] ? kinds[p] : INNER;
        let [one, other] = [0, 0]; // the side along both normals: an arc rises by about an eighth of their sum
        for (let k = 0; k < 3; k += 1) {
          const by = places[3 * q + k] - places[3 * p + k];
          one += by * normals[3 * p + k];
          other += by * normals[3 * q + k];
        }
        if (kinds[p] >= FIRST) one = 0; // there it has no normal
        if (kinds[q] >= FIRST) other = 0;
        if (kind === INNER && Math.abs(one) + Math.abs(other) <= 8 * most) return -1;
        const added = this.#added(kind, this.#between(p, q, 0.5), this.#isHeld(p, q));
        if (added < 0) return -1;
        const far = Math.hypot(...legs.joints.map((x, k) => x - (places[3 * p + k] + places[3 * q + k]) / 2));
        if (far > most) return added;
        this.#drop();
        return -1;
      });
      if (kinds.length === count) break;
    }
  }

  /** Takes the last vertex back. */
  #drop() {
    this.#kinds.length -= 1;
    for (const list of [this.#poses, this.#places, this.#normals, this.#kernels]) list.length -= 3;
    this.#ends.length -= 4;
  }

  #size() {
    const { high } = boxOf(this.#places);
    return Math.hypot(...high);
  }

  /** Whether both ends are in the same plane at the bottom or the top. */
  #isHeld(p, q) {
    const [one, other] = [this.#poses[3 * p + 2], this.#poses[3 * q + 2]];
    return one === other && (one === 0 || one === this.#reach);
  }

  #between(p, q, share) {
    const poses = this.#poses;
    return [0, 1, 2].map((k) => {
      const way = poses[3 * q + k] - poses[3 * p + k];
      return poses[3 * p + k] + share * (k < 2 ? way - TURN * Math.round(way / TURN) : way);
    });
  }

  /** Splits triangles at the vertices `halved(p, q)` on their sides, where it is no −1. */
  #split(halved) {
    const known = new Map();
    const middle = (p, q) => {
      const name = p < q ? p * 2 ** 26 + q : q * 2 ** 26 + p;
      let found = known.get(name);
      if (found === undefined) known.set(name, (found = p < q ? halved(p, q) : halved(q, p)));
      return found;
    };
    const [before, after] = [this.#triangles, []];
    for (let k = 0; k < before.length; k += 3) {
      let [a, b, c] = [before[k], before[k + 1], before[k + 2]];
      let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
      const count = (ab >= 0) + (bc >= 0) + (ca >= 0);
      if (count === 0) after.push(a, b, c);
      else if (count === 3) after.push(a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca);
      else {
        while (count === 1 ? ab < 0 : ca >= 0) [a, b, c, ab, bc, ca] = [b, c, a, bc, ca, ab];
        if (count === 1) after.push(a, ab, c, ab, b, c);
        else after.push(ab, b, bc, a, ab, bc, a, bc, c);
      }
    }
    this.#triangles = after;
  }

  /** The finished mesh. On cusp curves a vertex has two normals, that of its neighbours and the opposite one; where a leg closes, theirs. */
  finish() {
    const [triangles, kinds, places, normals] = [this.#triangles, this.#kinds, this.#places, this.#normals];
    const out = { positions: [], normals: [], index: new Uint32Array(triangles.length) };
    const copies = new Map();
    const along = (p, q) => normals[3 * p] * normals[3 * q] + normals[3 * p + 1] * normals[3 * q + 1] + normals[3 * p + 2] * normals[3 * q + 2];
    const push = (vertex, from, sign) => {
      for (let i = 0; i < 3; i += 1) {
        out.positions.push(places[3 * vertex + i]);
        out.normals.push(sign * normals[3 * from + i]);
      }
      return out.positions.length / 3 - 1;
    };
    for (let k = 0; k < triangles.length; k += 3) {
      const corners = [triangles[k], triangles[k + 1], triangles[k + 2]];
      const inner = corners.find((vertex) => kinds[vertex] === INNER) ?? corners.find((vertex) => kinds[vertex] === CUSP) ?? corners[0];
      corners.forEach((vertex, n) => {
        if (kinds[vertex] >= FIRST) return void (out.index[k + n] = push(vertex, inner, 1));
        const sign = kinds[vertex] === CUSP && along(vertex, inner) < 0 ? -1 : 1;
        const name = sign * (vertex + 1);
        if (!copies.has(name)) copies.set(name, push(vertex, vertex, sign));
        out.index[k + n] = copies.get(name);
      });
    }
    return { positions: new Float32Array(out.positions), normals: new Float32Array(out.normals), index: out.index, ...boxOf(places) };
  }
}

function boxOf(places) {
  const [low, high] = [[Infinity, Infinity, Infinity], [0, 0, 0]];
  places.forEach((x, k) => {
    low[k % 3] = Math.min(low[k % 3], x);
    high[k % 3] = Math.max(high[k % 3], x);
  });
  return { low, high };
}

const loops = new Map();

/** The loops of the sides of a cell that the surface crosses, `[[corner, corner], …]`, by the signs at its corners. */
function loopsOf(mask) {
  if (!loops.has(mask)) loops.set(mask, joined(mask));
  return loops.get(mask);
}

function joined(mask) {
  const isIn = (corner) => (mask >> corner) & 1;
  const links = new Map(); // the two neighbours of each side
  const link = (one, other) => {
    for (const [from, to] of [[one, other], [other, one]]) links.set(from, [...(links.get(from) ?? []), to]);
  };
  const side = (one, other) => `${Math.min(one, other)}${Math.max(one, other)}`;
  for (const face of FACES) {
    const crossed = [0, 1, 2, 3].filter((k) => isIn(face[k]) !== isIn(face[(k + 1) % 4]));
    const names = crossed.map((k) => side(face[k], face[(k + 1) % 4]));
    if (names.length === 2) link(...names);
    if (names.length === 4) { // corners with J > 0 are apart on a face, from either cell
      const first = isIn(face[1]) ? 0 : 1;
      link(names[first], names[first + 1]);
      link(names[(first + 2) % 4], names[(first + 3) % 4]);
    }
  }
  const found = [];
  while (links.size > 0) {
    const loop = [];
    for (let name = links.keys().next().value; name !== undefined; ) {
      loop.push(name);
      const next = links.get(name).find((other) => links.has(other) && !loop.includes(other));
      name = next;
    }
    for (const name of loop) links.delete(name);
    found.push(loop.map((name) => [Number(name[0]), Number(name[1])]));
  }
  return found;
}

/** The share of a side at which a value is 0 whose signs at its ends differ: false position. */
function zeroOf(value, start, end) {
  let [low, high, atLow, atHigh] = [0, 1, start, end];
  let share = start / (start - end);
  for (let k = 0; k < ROOTS; k += 1) {
    const now = value(share);
    if (now > 0 === start > 0) [low, atLow, atHigh] = [share, now, atHigh / 2];
    else [high, atHigh, atLow] = [share, now, atLow / 2];
    const next = low + ((high - low) * atLow) / (atLow - atHigh);
    if (!(next > 0 && next < 1)) break;
    share = next;
  }
  return share;
}
