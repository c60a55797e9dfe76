/** What is seen of the joint space, drawn by WebGL: lines and marks, the translucent surface, and the plane of a slice. */

import * as THREE from "../three/three.min.mjs";
import { FAR } from "./camera.js";

const BUCKETS = 4096; // of depths
const THROUGH = 0.65; // of lines behind the surface
const TURNED = 0.9995; // cosine of the angle after which triangles are sorted anew

const LINES = {
  vertexShader: `
    in vec2 corner; in vec3 from; in vec3 to; in vec3 tint; in float width;
    uniform mat4 clip; uniform vec2 middle; uniform float density; uniform float nearer;
    out vec2 place; out float span; out vec3 colour; out float radius;
    void main() {
      vec4 a = clip * vec4(from, 1.0); vec4 b = clip * vec4(to, 1.0);
      vec2 p = a.xy / a.w * middle; vec2 q = b.xy / b.w * middle;
      vec2 way = q - p; span = length(way); way = span > 1e-6 ? way / span : vec2(1.0, 0.0);
      radius = 0.5 * width * density;
      float reach = radius + 0.75; float end = 2.0 * corner.x - 1.0;
      vec2 at = mix(p, q, corner.x) + end * reach * way + corner.y * reach * vec2(-way.y, way.x);
      place = vec2(corner.x * span + end * reach, corner.y * reach); colour = tint;
      gl_Position = vec4(at / middle, mix(a.z / a.w, b.z / b.w, corner.x) - nearer, 1.0);
    }`,
  fragmentShader: `
    precision highp float;
    in vec2 place; in float span; in vec3 colour; in float radius;
    uniform float isTube; uniform float strength; out vec4 pixel;
    void main() {
      float away = length(vec2(max(max(-place.x, place.x - span), 0.0), place.y));
      float alpha = clamp(radius - away + 0.5, 0.0, 1.0) * strength;
      if (alpha < 0.02) discard;
      float round = clamp(abs(place.y) / radius, 0.0, 1.0);
      vec3 lit = mix(mix(colour, vec3(1.0), 0.45), 0.72 * colour, round * round);
      pixel = vec4(mix(colour, lit, isTube), alpha);
    }`,
};

const MARKS = {
  vertexShader: `
    in vec3 position; in vec3 tint; in vec2 kind; // its shape and its size
    uniform mat4 clip; uniform float density;
    out vec3 colour; flat out float form; out float size;
    void main() {
      vec4 at = clip * vec4(position, 1.0);
      colour = tint; form = kind.x; size = kind.y * density;
      gl_Position = vec4(at.xyz / at.w, 1.0); gl_Position.z -= 0.004; gl_PointSize = size + 2.0;
    }`,
  fragmentShader: `
    precision highp float;
    in vec3 colour; flat in float form; in float size;
    uniform vec3 paper; out vec4 pixel;
    float outside(vec2 p, float r) {
      if (form < 0.5 || form > 3.5) return length(p) - r;
      if (form < 1.5) return 0.75 * (abs(p.x) + abs(p.y) - 1.15 * r);
      if (form < 2.5) return max(abs(p.x), abs(p.y)) - 0.8 * r;
      return max(abs(p.x) * 0.866 - p.y * 0.5, p.y) - 0.55 * r;
    }
    void main() {
      vec2 p = (gl_PointCoord - 0.5) * (size + 2.0);
      float far = outside(p, 0.5 * size);
      if (far > 0.5) discard;
      float inner = clamp(-far - 0.16 * size, 0.0, 1.0);
      vec3 filled = form > 3.5 ? mix(colour, vec3(1.0), clamp(0.8 - length(p + 0.16 * size) / (0.36 * size), 0.0, 0.75)) : colour;
      vec3 body = form < 0.5 ? mix(colour, paper, inner) : filled;
      float rim = form < 0.5 ? 1.0 : clamp(-far - 0.08 * size, 0.0, 1.0);
      pixel = vec4(mix(paper, body, rim), clamp(0.5 - far, 0.0, 1.0));
    }`,
};

const SURFACE = {
  vertexShader: `
    in vec3 position; in vec3 normal;
    uniform mat4 clip; uniform mat3 turned; uniform vec3 fixedLeg; uniform vec4 eye;
    out vec3 side; out vec3 toEye; out float level;
    void main() {
      side = turned * normal; level = dot(fixedLeg, position);
      gl_Position = clip * vec4(position, 1.0);
      toEye = vec3(-eye.xy * gl_Position.xy, eye.z * gl_Position.w);
    }`,
  fragmentShader: `
    precision highp float;
    in vec3 side; in vec3 toEye; in float level;
    uniform vec3 more; uniform vec3 fewer; uniform vec3 ink; uniform vec3 slice; uniform float spacing; uniform vec2 alphas;
    out vec4 pixel;
    void main() {
      if (slice.z * (level - slice.x) < 0.0) discard;
      vec3 n = normalize(side); float facing = dot(n, normalize(toEye)); float flat_ = abs(facing);
      vec3 base = mix(fewer, more, smoothstep(-0.03, 0.03, facing));
      vec3 up = facing < 0.0 ? -n : n;
      float light = 0.72 + 0.28 * clamp(dot(up, normalize(vec3(-0.35, 0.75, 0.6))), -0.4, 1.0);
      float gloss = pow(max(dot(up, normalize(vec3(-0.2, 0.55, 0.85))), 0.0), 40.0);
      float each = level / spacing; float wide = max(fwidth(each), 1e-5);
      float ring = (1.0 - smoothstep(0.4, 1.3, abs(fract(each - 0.5) - 0.5) / wide)) * clamp(0.35 / wide, 0.0, 1.0);
      vec3 colour = mix(base * light + 0.16 * gloss, ink, 0.35 * ring);
      float alpha = mix(alphas.y, alphas.x, flat_ * (2.0 - flat_)) + 0.2 * ring + 0.1 * gloss;
      pixel = vec4(colour, clamp(alpha * slice.y, 0.0, 1.0));
    }`,
};

const PLANE = {
  vertexShader: `
    in vec3 position; in vec4 tint; uniform mat4 clip; out vec4 colour;
    void main() { colour = tint; gl_Position = clip * vec4(position, 1.0); gl_Position.z += 0.0006 * gl_Position.w; }`,
  fragmentShader: "precision highp float; in vec4 colour; out vec4 pixel; void main() { pixel = colour; }",
};

export class WebGlDrawing {
  #renderer;
  #scene = new THREE.Scene();
  #camera = new THREE.Camera();
  #shared = {
    clip: { value: new Array(16).fill(0) }, middle: { value: [1, 1] }, density: { value: 1 }, paper: { value: [1, 1, 1] },
    turned: { value: new Array(9).fill(0) }, eye: { value: [1, 1, 1, 1] }, fixedLeg: { value: [1, 0, 0] }, more: { value: [1, 1, 1] },
    fewer: { value: [1, 1, 1] }, ink: { value: [0, 0, 0] }, spacing: { value: 1 }, alphas: { value: [0.3, 0.7] },
  };
  #lines = new Map(); // meshes by name
  #marks;
  #halves; // of the surface: behind the plane of the slice, and before it
  #plane;
  #mesh = null;
  #sorted = null; // the direction in which its triangles are sorted
  #order = 0;

  /** `onLost()` and `onBack()` are told when the browser takes the context away, and gives one back. */
  constructor(canvas, context, { onLost, onBack }) {
    this.#renderer = new THREE.WebGLRenderer({ canvas, context });
    this.#renderer.setClearColor(0, 0);
    this.#renderer.sortObjects = true;
    canvas.addEventListener("webglcontextlost", onLost);
    canvas.addEventListener("webglcontextrestored", onBack);
    const marks = new THREE.Points(new THREE.BufferGeometry(), this.#material(MARKS, ["clip", "density", "paper"]));
    this.#marks = this.#added(marks, 3);
    const names = ["clip", "turned", "fixedLeg", "eye", "more", "fewer", "ink", "spacing", "alphas"];
    const geometry = new THREE.BufferGeometry();
    const half = (order) => this.#added(new THREE.Mesh(geometry, this.#material(SURFACE, names, { slice: { value: [0, 1, 1] } })), order);
    this.#halves = [half(4), half(6)];
    this.#plane = this.#added(new THREE.Mesh(new THREE.BufferGeometry(), this.#material(PLANE, ["clip"])), 5);
  }

  #material(shaders, names, own = {}) {
    const uniforms = { ...Object.fromEntries(names.map((name) => [name, this.#shared[name]])), ...own };
    const isSolid = shaders === LINES || shaders === MARKS;
    return new THREE.RawShaderMaterial({ ...shaders, uniforms, glslVersion: THREE.GLSL3, transparent: true, depthWrite: isSolid, side: THREE.DoubleSide });
  }

  #added(object, order) {
    object.frustumCulled = false;
    object.renderOrder = order;
    object.visible = false;
    this.#scene.add(object);
    return object;
  }

  /** Whether pictures are computed without a graphics processor. */
  get isSoftware() {
    const gl = this.#renderer.getContext();
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    return /swiftshader|llvmpipe|software/i.test(info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "");
  }

  /** Takes the size in pixels of the page, how many pixels of the picture are one of those, and how bold lines and marks are. */
  resize(width, height, density, bold) {
    this.#renderer.setPixelRatio(density);
    this.#renderer.setSize(width, height, false);
    this.#shared.middle.value = [(width * density) / 2, (height * density) / 2];
    this.#shared.density.value = density * bold;
  }

  /** Takes colours by name, each [red, green, blue] up to 1, and how opaque the surface is: seen from before, and along it. */
  colours({ paper, more, fewer, ink }, alphas) {
    for (const [name, value] of Object.entries({ paper, more, fewer, ink, alphas })) this.#shared[name].value = value;
  }

  /** Takes a mesh, or null. */
  surface(mesh) {
    this.#mesh = mesh;
    this.#sorted = null;
    for (const half of this.#halves) half.visible = Boolean(mesh);
    if (!mesh) return;
    const old = this.#halves[0].geometry;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(mesh.positions, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(mesh.index), 1));
    for (const half of this.#halves) half.geometry = geometry;
    old.dispose();
  }

  /** Takes lines of a name: `[{points, colour, width}]`; they are tubes, or behind all else. */
  lines(name, list, { isTube = false, isBehind = false } = {}) {
    const count = list.reduce((sum, { points }) => sum + Math.max(points.length - 1, 0), 0);
    const [from, to, tint, width] = [3, 3, 3, 1].map((size) => new Float32Array(size * count));
    let n = 0;
    for (const { points, colour, width: wide } of list) {
      for (let k = 1; k < points.length; k += 1) {
        from.set(points[k - 1], 3 * n);
        to.set(points[k], 3 * n);
        tint.set(colour, 3 * n);
        width[n] = wide;
        n += 1;
      }
    }
    let meshes = this.#lines.get(name);
    if (!meshes) {
      const make = (order, strength, depthWrite) => {
        const own = { isTube: { value: isTube ? 1 : 0 }, nearer: { value: isBehind ? 0 : 0.0012 }, strength: { value: strength } };
        const made = this.#added(new THREE.Mesh(new THREE.BufferGeometry(), this.#material(LINES, ["clip", "middle", "density"], own)), order);
        made.material.alphaToCoverage = depthWrite;
        made.material.depthWrite = depthWrite;
        return made;
      };
      const order = this.#order++ / 10;
      meshes = isBehind ? [make(0, 1, false)] : [make(1 + order, 1, true), make(7 + order, THROUGH, false)]; // and seen through what is before them
      this.#lines.set(name, meshes);
    }
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.instanceCount = count;
    geometry.setIndex([0, 1, 2, 2, 1, 3]);
    geometry.setAttribute("corner", new THREE.BufferAttribute(new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]), 2));
    for (const [attribute, array] of Object.entries({ from, to, tint })) geometry.setAttribute(attribute, new THREE.InstancedBufferAttribute(array, 3));
    geometry.setAttribute("width", new THREE.InstancedBufferAttribute(width, 1));
    meshes[0].geometry.dispose();
    for (const mesh of meshes) {
      mesh.geometry = geometry;
      mesh.visible = count > 0;
    }
  }

  /** Takes marks: `[{place, colour, form, size}]`. */
  marks(list) {
    const geometry = new THREE.BufferGeometry();
    const attribute = (size, values) => new THREE.BufferAttribute(new Float32Array(list.flatMap(values)), size);
    geometry.setAttribute("position", attribute(3, ({ place }) => place));
    geometry.setAttribute("tint", attribute(3, ({ colour }) => colour));
    geometry.setAttribute("kind", attribute(2, ({ form, size }) => [form, size]));
    this.#marks.geometry.dispose();
    this.#marks.geometry = geometry;
    this.#marks.visible = list.length > 0;
  }

  /** Takes the areas of a slice: `[{rings, colour, alpha}]` with rings of places (L1, L2, L3) in the plane across `axis`. */
  plane(areas, axis) {
    const [u, v] = [0, 1, 2].filter((other) => other !== axis);
    const [positions, tints, index] = [[], [], []];
    for (const { rings, colour, alpha } of areas) {
      const start = positions.length / 3;
      const [outline, ...holes] = rings.map((ring) => ring.map((place) => new THREE.Vector2(place[u], place[v])));
      for (const place of rings.flat()) {
        positions.push(...place);
        tints.push(...colour, alpha);
      }
      for (const triangle of THREE.ShapeUtils.triangulateShape(outline, holes)) index.push(...triangle.map((k) => start + k));
    }
    this.#plane.geometry.dispose();
    this.#plane.geometry = new THREE.BufferGeometry();
    this.#plane.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(positions), 3));
    this.#plane.geometry.setAttribute("tint", new THREE.BufferAttribute(new Float32Array(tints), 4));
    this.#plane.geometry.setIndex(index);
    this.#plane.visible = index.length > 0;
  }

  /** Draws all from a camera, the slice being at a length of the leg across `axis`; contours of the surface are so far apart. */
  render(camera, { axis, level, spacing }) {
    const [right, up, eye] = camera.axes;
    this.#shared.clip.value = camera.matrix;
    this.#shared.turned.value = [0, 1, 2].flatMap((k) => [right[k], up[k], eye[k]]);
    const [width, height] = this.#shared.middle.value.map((x) => x / this.#renderer.getPixelRatio() / camera.scale);
    this.#shared.eye.value = [width, height, FAR, 0];
    this.#shared.fixedLeg.value = [0, 1, 2].map((k) => (k === axis ? 1 : 0));
    this.#shared.spacing.value = spacing;
    const side = eye[axis] > 0 ? 1 : -1; // on which the eye is
    const isCut = level !== null;
    [[isCut ? level : 0, 1, isCut ? -side : 0], [isCut ? level : 0, 0.42, side]].forEach((slice, k) => (this.#halves[k].material.uniforms.slice.value = slice));
    this.#halves[1].visible = isCut && Boolean(this.#mesh);
    if (this.#mesh) this.#sort(eye);
    this.#renderer.render(this.#scene, this.#camera);
  }

  /** Orders the triangles from the back to the front. */
  #sort(eye) {
    if (this.#sorted && this.#sorted.reduce((sum, x, k) => sum + x * eye[k], 0) > TURNED) return;
    this.#sorted = eye;
    const { positions, index } = this.#mesh;
    const depths = new Float32Array(positions.length / 3);
    let [low, high] = [Infinity, -Infinity];
    for (let k = 0; k < depths.length; k += 1) {
      const depth = eye[0] * positions[3 * k] + eye[1] * positions[3 * k + 1] + eye[2] * positions[3 * k + 2];
      depths[k] = depth;
      low = Math.min(low, depth);
      high = Math.max(high, depth);
    }
    const count = index.length / 3;
    const [places, starts] = [new Uint16Array(count), new Uint32Array(BUCKETS + 1)];
    const fine = (BUCKETS - 1) / (3 * (high - low) || 1);
    for (let t = 0; t < count; t += 1) {
      const bucket = (depths[index[3 * t]] + depths[index[3 * t + 1]] + depths[index[3 * t + 2]] - 3 * low) * fine;
      places[t] = bucket;
      starts[places[t] + 1] += 1;
    }
    for (let k = 0; k < BUCKETS; k += 1) starts[k + 1] += starts[k];
    const attribute = this.#halves[0].geometry.index;
    for (let t = 0; t < count; t += 1) {
      const at = 3 * starts[places[t]]++;
      attribute.array[at] = index[3 * t];
      attribute.array[at + 1] = index[3 * t + 1];
      attribute.array[at + 2] = index[3 * t + 2];
    }
    attribute.needsUpdate = true;
  }
}
