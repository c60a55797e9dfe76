/** The motion bar: a loop round the selected cusp, or another path, played by time or moved by hand. */

import { shortened, toNumber } from "./decimals.js";
import { byId, on, write } from "./dom.js";
import { placed } from "./poses.js";
import { letterOf } from "./state.js";

const SECONDS = 3; // that a path takes
const calm = matchMedia("(prefers-reduced-motion: reduce)");

export class Motion {
  #path = null;
  #samples = []; // in floats, with angles that do not jump
  #times = []; // of the samples, 0 to 1
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
    return this.#path ? [this.#path.from.pose, this.#path.to.pose].map((pose) => String(pose ?? "")) : [];
  }

  /** Takes a path; null while there is none, with the reason if there can be none. */
  show(path, reason = "") {
    if (!path && !this.#path && byId("loop-text").textContent === reason) return;
    this.pause();
    this.#path = path;
    this.#samples = path ? numbersOf(path.samples) : [];
    const times = (path?.samples ?? []).map(({ time }) => toNumber(time));
    this.#times = times.map((time) => time / (times.at(-1) || 1));
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
    const k = Math.max(this.#times.findLastIndex((begin, j) => begin <= time && j + 1 < this.#times.length), 0);
    const [from, to] = [this.#samples[k], this.#samples[k + 1]];
    const share = (time - this.#times[k]) / (this.#times[k + 1] - this.#times[k]);
    const sample = Object.fromEntries(Object.keys(from).map((name) => [name, from[name] + share * (to[name] - from[name])]));
    const nearest = this.#path.samples[share < 0.5 ? k : k + 1];
    const isFree = this.#samples.some(({ l1 }) => l1 !== this.#samples[0].l1);
    const text = `${isFree ? `L1 = ${shortened(sample.l1, 5)}, ` : ""}L2 = ${shortened(sample.l2, 5)}, L3 = ${shortened(sample.l3, 5)}${placed(nearest)}, at least ${shortened(nearest.clearance_deg, 3)}° from a singularity`;
    write("loop-now", text);
    byId("scrubber").ariaValueText = `${Math.round(time * 100)} %: ${text}`;
    this.#onMove(sample);
  }
}

/** A path in words: where it leads, and what is proved of it. */
export function described({ cusp, l1, l2, l3, from, to, sign, limits, clearance, certificate }) {
  const jointsOf = (end) => (l1 ? "" : ` of L1 = ${shortened(end.l1, 8)}, L2 = ${shortened(end.l2, 8)}, L3 = ${shortened(end.l3, 8)}`);
  const joints = l1 ? ` of L1 = ${l1}, L2 = ${l2}, L3 = ${l3}` : "";
  const proofs = [
    `J ${sign > 0 ? ">" : "<"} 0`,
    ...(clearance ? [`at least ${shortened(clearance.proved, 4)}° from singular poses`] : []),
    ...(limits ? ["within the joint limits"] : []),
  ];
  return (
    `${cusp ? `Round cusp ${letterOf(cusp - 1)} from` : "From"} pose ${from.pose ?? ""}${jointsOf(from)} to pose ${to.pose ?? ""}${jointsOf(to)}${joints} without a singularity: ` +
    `${proofs.join(", ")}, and |determinant| ≥ ${shortened(certificate.least_determinant, 3)}, proved all the way.`
  );
}

function numbersOf(samples) {
  const names = ["l1", "l2", "l3", "alpha_deg", "theta1_deg"];
  return samples.map((sample) => Object.fromEntries(names.map((name) => [name, Number(sample[name])])));
}
