/** The motion bar: a loop round the selected cusp, played by time or moved by hand. */

import { shortened } from "./decimals.js";
import { byId, on, write } from "./dom.js";
import { placed } from "./poses.js";
import { letterOf } from "./state.js";

const SECONDS = 3; // that a loop takes
const calm = matchMedia("(prefers-reduced-motion: reduce)");

export class Motion {
  #path = null;
  #samples = []; // in floats, with angles that do not jump
  #time = 0; // 0 to 1
  #way = 1; // forwards or backwards
  #frame = null;
  #last = null;
  #onMove;

  /** `onMove(sample)` is told where the manipulator is. */
  constructor({ onMove }) {
    this.#onMove = onMove;
    on("play", "click", () => (this.#frame === null ? this.play() : this.pause()));
    on("scrubber", "input", () => {
      this.pause();
      this.#go(Number(byId("scrubber").value) / 100);
    });
  }

  get samples() {
    return this.#samples;
  }

  /** The numbers of the poses at both ends. */
  get ends() {
    return this.#path ? [this.#path.from.pose, this.#path.to.pose].map(String) : [];
  }

  /** Takes a path; null while there is none, with the reason if there can be none. */
  show(path, reason = "") {
    if (!path && !this.#path && byId("loop-text").textContent === reason) return;
    this.pause();
    this.#path = path;
    this.#samples = path ? numbersOf(path.samples) : [];
    [this.#time, this.#way] = [0, 1];
    byId("scrubber").value = 0;
    byId("play").disabled = byId("scrubber").disabled = !path;
    write("loop-text", path ? described(path) : reason);
    write("loop-now", "");
    byId("scrubber").ariaValueText = null;
  }

  /** Plays once through; from the end it goes back. */
  play() {
    if (!this.#path) return;
    if (this.#time >= 1) this.#way = -1;
    if (this.#time <= 0) this.#way = 1;
    this.#last = null;
    write("play", "Pause");
    this.#frame = requestAnimationFrame((now) => this.#tick(now));
  }

  playUnlessCalm() {
    if (!calm.matches) this.play();
  }

  pause() {
    if (this.#frame !== null) cancelAnimationFrame(this.#frame);
    this.#frame = null;
    write("play", "Play");
  }

  #tick(now) {
    const seconds = this.#last === null ? 0 : (now - this.#last) / 1000;
    this.#last = now;
    const time = this.#time + (this.#way * seconds) / SECONDS;
    this.#go(Math.min(Math.max(time, 0), 1));
    byId("scrubber").value = Math.round(this.#time * 100);
    if (seconds > 0 && this.#time % 1 === 0) this.pause();
    else this.#frame = requestAnimationFrame((later) => this.#tick(later));
  }

  #go(time) {
    this.#time = time;
    const at = time * (this.#samples.length - 1);
    const [k, part] = [Math.min(Math.floor(at), this.#samples.length - 2), at % 1];
    const [from, to] = [this.#samples[k], this.#samples[k + 1]];
    const share = at > k + 1 - 1e-9 ? 1 : part;
    const sample = Object.fromEntries(Object.keys(from).map((name) => [name, from[name] + share * (to[name] - from[name])]));
    const nearest = this.#path.samples[Math.round(at)];
    const text = `L2 = ${shortened(sample.l2, 5)}, L3 = ${shortened(sample.l3, 5)}${placed(nearest)}, at least ${shortened(nearest.clearance_deg, 3)}° from a singularity`;
    write("loop-now", text);
    byId("scrubber").ariaValueText = `${Math.round(time * 100)} %: ${text}`;
    this.#onMove(sample);
  }
}

function described({ cusp, l1, l2, l3, from, to, sign, certificate }) {
  const joints = `L1 = ${l1}, L2 = ${l2}, L3 = ${l3}`;
  return (
    `Round cusp ${letterOf(cusp - 1)} from pose ${from.pose} to pose ${to.pose} of ${joints} without a singularity: ` +
    `J ${sign > 0 ? ">" : "<"} 0, and |determinant| ≥ ${shortened(certificate.least_determinant, 3)}, proved all the way.`
  );
}

function numbersOf(samples) {
  const names = ["l1", "l2", "l3", "alpha_deg", "theta1_deg"];
  return samples.map((sample) => Object.fromEntries(names.map((name) => [name, Number(sample[name])])));
}
