/**
 * The legs of a manipulator in floats, one of them fixed: where the platform is, how long the others are, where it is
 * singular (J = 0), and where three poses coalesce (E = 0, too). For drawing; what counts comes from the service.
 *
 * The fixed leg of length L has the direction e(θ), the platform the angle α; a free leg has the squared length
 * |L e + p − a|², p being its platform point turned by α, a its base point, both seen from the fixed leg. With the
 * slopes F_α = (L e − a)·p⊥ and F_θ = L (p − a)·e⊥ of half of it, and G of the other one, J = (F_α G_θ − F_θ G_α) / L,
 * and E is the slope of J along (−F_θ, F_α), or (−G_θ, G_α), which is the same direction where J = 0.
 */

const STEP = 1e-6; // of differences
const NEAR = 1e-9; // at which a zero is known
const FAR = 0.5; // radians, or lengths over the size of the manipulator, that a zero may be away

export class Legs {
  j = 0; // of the pose that was looked at last, as all that follows
  jAlpha = 0;
  jTheta = 0;
  jLength = 0;
  fAlpha = 0;
  fTheta = 0;
  gAlpha = 0;
  gTheta = 0;

  /** `base` and `platform` are the corners of both triangles, `leg` the number of the fixed leg. */
  constructor({ base, platform }, leg) {
    this.leg = leg;
    const free = [1, 2, 3].filter((other) => other !== leg);
    const from = (points) => free.map((other) => [0, 1].map((k) => points[other - 1][k] - points[leg - 1][k]));
    [[this.mx, this.my], [this.nx, this.ny]] = from(platform);
    [[this.ax, this.ay], [this.bx, this.by]] = from(base);
    this.size = Math.max(...[...from(platform), ...from(base)].map(([x, y]) => Math.hypot(x, y)));
    this.places = [leg, ...free].map((name) => name - 1); // of the fixed leg and the free ones in (L1, L2, L3)
  }

  #turn(alpha, theta) {
    const [c, s] = [Math.cos(alpha), Math.sin(alpha)];
    this.px = c * this.mx - s * this.my;
    this.py = s * this.mx + c * this.my;
    this.qx = c * this.nx - s * this.ny;
    this.qy = s * this.nx + c * this.ny;
    this.c = Math.cos(theta);
    this.s = Math.sin(theta);
  }

  /** J, which is linear in the length: its value at 0 and its slope are kept as members. */
  line(alpha, theta) {
    this.#turn(alpha, theta);
    const { c, s, px, py, qx, qy, ax, ay, bx, by } = this;
    const [f, g] = [(py - ay) * c - (px - ax) * s, (qy - by) * c - (qx - bx) * s];
    this.start = (ax * py - ay * px) * g - f * (bx * qy - by * qx);
    this.rise = (s * px - c * py) * g - f * (s * qx - c * qy);
  }

  /** Looks at a pose: J, its slopes in α, θ and L, the slopes of both squared lengths, and the lengths. */
  at(alpha, theta, length) {
    this.#turn(alpha, theta);
    const { c, s, px, py, qx, qy, ax, ay, bx, by } = this;
    const [fx, fy, gx, gy] = [px - ax, py - ay, qx - bx, qy - by];
    const [ux, uy, vx, vy] = [length * c - ax, length * s - ay, length * c - bx, length * s - by];
    const [fAlpha, gAlpha] = [uy * px - ux * py, vy * qx - vx * qy];
    const [f, g] = [fy * c - fx * s, gy * c - gx * s]; // F_θ / L, G_θ / L
    const [p, q] = [px * c + py * s, qx * c + qy * s]; // their slopes in α
    this.j = fAlpha * g - f * gAlpha;
    this.jAlpha = -(ux * px + uy * py) * g + fAlpha * q - p * gAlpha + f * (vx * qx + vy * qy);
    this.jTheta = length * p * g - fAlpha * (gx * c + gy * s) + (fx * c + fy * s) * gAlpha - f * length * q;
    this.jLength = (s * px - c * py) * g - f * (s * qx - c * qy);
    [this.fAlpha, this.gAlpha, this.fTheta, this.gTheta, this.f, this.g] = [fAlpha, gAlpha, length * f, length * g, f, g];
    const [x, y, z, w] = [length * c + fx, length * s + fy, length * c + gx, length * s + gy];
    this.ends = [x, y, z, w]; // of the free legs, from their base points
    [this.one, this.two] = [Math.sqrt(x * x + y * y), Math.sqrt(z * z + w * w)]; // the lengths of the free legs
    [this.oneAlong, this.twoAlong] = [x * c + y * s, z * c + w * s]; // times their slopes in L
    [this.alpha, this.theta, this.length] = [alpha, theta, length];
  }

  get #isF() {
    return this.fAlpha * this.fAlpha + this.fTheta * this.fTheta > this.gAlpha * this.gAlpha + this.gTheta * this.gTheta;
  }

  /** The direction in which a singular pose moves while all lengths stand still: [dα, dθ], of length 1. */
  get kernel() {
    const [u, v] = this.#isF ? [this.fAlpha, this.fTheta] : [this.gAlpha, this.gTheta];
    const size = Math.hypot(u, v) || 1;
    return [-v / size, u / size];
  }

  /** (L1, L2, L3). */
  get joints() {
    return this.#placed(this.length, this.one, this.two);
  }

  /** The normal of the singular surface in (L1, L2, L3), forces of the legs that balance: to the side that has two poses more. */
  get normal() {
    const { one, two, fAlpha, gAlpha, f, g, size } = this;
    const isTurn = fAlpha * fAlpha + gAlpha * gAlpha > size * size * (f * f + g * g);
    const [x, y] = isTurn ? [gAlpha, -fAlpha] : [size * g, -size * f];
    const sign = x * this.#curved(this.px, this.py, this.ax, this.ay) + y * this.#curved(this.qx, this.qy, this.bx, this.by) < 0 ? -1 : 1;
    const force = this.#placed(-x * this.oneAlong - y * this.twoAlong, x * one, y * two);
    const whole = sign * Math.hypot(...force) || 1;
    return force.map((part) => part / whole);
  }

  /** The second derivative along the kernel of half a squared length. */
  #curved(px, py, ax, ay) {
    const [u, v] = this.kernel;
    const [x, y] = [this.length * this.c, this.length * this.s];
    const cross = x * px + y * py;
    return u * u * (ax * px + ay * py - cross) + 2 * u * v * cross + v * v * (ax * x + ay * y - cross);
  }

  #placed(...values) {
    const out = [0, 0, 0];
    values.forEach((value, k) => (out[this.places[k]] = value));
    return out;
  }

  /** Moves a pose onto J = 0 by the shortest way, with the length held if `isHeld`; it is then the one looked at. */
  ontoSurface(alpha, theta, length, isHeld = false) {
    for (let k = 0; k < 3; k += 1) {
      this.at(alpha, theta, length);
      const rise = isHeld ? 0 : this.jLength * this.size;
      const over = this.jAlpha ** 2 + this.jTheta ** 2 + rise ** 2;
      if (!(over > 0) || Math.abs(this.j) < NEAR ** 2 * over) return;
      const by = -this.j / over;
      [alpha, theta, length] = [alpha + by * this.jAlpha, theta + by * this.jTheta, length + by * rise * this.size];
    }
    this.at(alpha, theta, length);
  }

  /** Moves a pose onto J = E = 0 as well; tells whether one was near. */
  ontoEdge(alpha, theta, length, isHeld = false) {
    return this.#onto([alpha, theta, length], (pose) => this.#edge(pose, isHeld));
  }

  /** Moves a pose to where a free leg closes, the first or the second; tells whether one was near. */
  ontoClosed(second, alpha, theta, length, isHeld = false) {
    return this.#onto([alpha, theta, length], (pose) => this.#closed(second, pose, isHeld));
  }

  /** Moves a pose onto two zeros by the shortest way: `zeros(pose)` has the values and their slopes. */
  #onto(pose, zeros) {
    let at = pose;
    for (let k = 0; k < 8; k += 1) {
      const { values: [j, e], rows: [p, q] } = zeros(at);
      const [pp, pq, qq] = [dot(p, p), dot(p, q), dot(q, q)];
      const area = pp * qq - pq * pq;
      if (!(area > 1e-18 * pp * qq)) return false;
      const [s, t] = [(qq * j - pq * e) / area, (pp * e - pq * j) / area];
      const by = p.map((x, i) => -(s * x + t * q[i]));
      at = at.map((x, i) => x + by[i] * (i === 2 ? this.size : 1));
      if (Math.hypot(...by) < NEAR) break;
    }
    this.at(...at);
    return Math.hypot(at[0] - pose[0], at[1] - pose[1], (at[2] - pose[2]) / this.size) < FAR;
  }

  /** The direction of the curve J = E = 0, lengths over the size of the manipulator. */
  tangent(pose) {
    const [p, q] = this.#edge(pose, false).rows;
    const t = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    const size = Math.hypot(...t) || 1;
    return t.map((x) => x / size);
  }

  /** J and E, and their slopes in α, θ and L, those in L times the size. */
  #edge(pose, isHeld) {
    this.at(...pose);
    const isF = this.#isF;
    const value = () => (isF ? this.jTheta * this.fAlpha - this.jAlpha * this.fTheta : this.jTheta * this.gAlpha - this.jAlpha * this.gTheta);
    const rise = isHeld ? 0 : this.size;
    const [values, slope] = [[this.j, value()], [this.jAlpha, this.jTheta, this.jLength * rise]];
    const eSlope = [STEP, STEP, STEP * this.size].map((step, k) => {
      const [low, high] = [-step, step].map((by) => {
        this.at(...pose.with(k, pose[k] + by));
        return value();
      });
      return ((high - low) / (2 * step)) * (k === 2 ? rise : 1);
    });
    return { values, rows: [slope, eSlope] };
  }

  /** The end of a free leg, and its slopes. */
  #closed(second, pose, isHeld) {
    this.at(...pose);
    const [x, y] = second ? [this.qx, this.qy] : [this.px, this.py];
    const rise = isHeld ? 0 : this.size;
    const rows = [[-y, -this.length * this.s, this.c * rise], [x, this.length * this.c, this.s * rise]];
    return { values: this.ends.slice(second ? 2 : 0, second ? 4 : 2), rows };
  }
}

const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
