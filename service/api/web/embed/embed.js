/** One board and its slider, for an <iframe>: what an address of the explorer shows, without a key, and with the questions of the board only. */

import { ask } from "../explorer/api.js";
import { legendOf, showLegend, sliceOf } from "../explorer/curves.js";
import { decimal, gridPlaces, toNumber } from "../explorer/decimals.js";
import { byId, on, write } from "../explorer/dom.js";
import { measured } from "../explorer/geometry.js";
import { JointSpace } from "../explorer/joint_space.js";
import { Mechanism } from "../explorer/mechanism.js";
import { posesAt } from "../explorer/merging.js";
import { Motion } from "../explorer/motion.js";
import { nearestIn, vectorOf } from "../explorer/kinematics.js";
import { curvesOf, loopOf, pictureOf, posesOf } from "../explorer/questions.js";
import { showCount } from "../explorer/slice.js";
import { SpaceView } from "../explorer/space_view.js";
import { letterOf, stateOf } from "../explorer/state.js";

const REST = 300; // ms without a change after which finer curves are asked for
const STEPS = 400; // of the slider
const REACH = 0.2; // by which the lengths of the slider differ from that of the link, unless the link says which

/** Asks a question, and says what goes wrong. */
async function answerTo([path, question]) {
  try {
    const answer = await ask(path, question);
    write("why-text", "");
    return answer;
  } catch (error) {
    write("why-text", error.status === 401 ? "This service asks for a key, which a framed page does not take." : error.message);
    return null;
  }
}

/** The slice on the plane of L2 and L3, on the torus or in the joint space, and L1 as the slider. */
class Slice {
  #state;
  #joint = new JointSpace({ onSelect: (index) => this.#joint.select(index), onVisit() {}, onPick() {}, onHold() {}, onPose() {}, onLimits() {}, onZoom() {} });
  #space = new SpaceView({ onSelect() {}, onGo: (l1) => this.#go(l1), onEye() {}, ask: (_, question) => answerTo(question) });
  #next = null; // the state that is asked for next
  #isAsking = false;
  #timer = null;

  constructor(state, range) {
    this.#state = state;
    this.#joint.drawLimits(state.limits);
    this.#space.open(state.view === "space");
    const l1 = toNumber(state.l1);
    const [low, high] = range ?? [(1 - REACH) * l1, (1 + REACH) * l1];
    const slider = Object.assign(byId("l1-slider"), { min: 0, max: STEPS, value: (STEPS * (l1 - low)) / (high - low) });
    const places = gridPlaces(high - low);
    slider.ariaValueText = `L1 = ${state.l1}`;
    on(slider, "input", () => this.#go(decimal(low + (Number(slider.value) / STEPS) * (high - low), places)));
    this.#rest();
  }

  #go(l1) {
    byId("l1-slider").ariaValueText = `L1 = ${l1}`;
    this.#state = { ...this.#state, l1 };
    this.#ask();
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#rest(), REST);
  }

  /** Asks for the newest state while the slider moves, one at a time. */
  async #ask() {
    this.#next = this.#state;
    if (this.#isAsking) return;
    this.#isAsking = true;
    while (this.#next) {
      const state = this.#next;
      this.#next = null;
      const curves = await answerTo(pictureOf(state));
      if (curves) this.#draw(state, curves);
    }
    this.#isAsking = false;
  }

  async #rest() {
    const state = this.#state;
    const curves = await answerTo(curvesOf(state));
    if (curves && state === this.#state) this.#draw(state, curves);
  }

  #draw({ geometry, l1, view, cusp, limits, eye }, curves) {
    const slice = sliceOf(curves, l1);
    const selected = Math.min(cusp, Math.max(slice.count - 1, 0));
    if (this.#space.isOpen) this.#space.set({ geometry, l1, limits, eye, slice, curves, selected, isShown: true });
    else this.#joint.draw(slice, curves, view, selected);
    showCount(slice);
    showLegend(legendOf(curves, view));
  }
}

/** The mechanism at the pose of the link, or on the loop round its cusp. */
class Machine {
  #state;
  #mechanism = new Mechanism({ onDrag() {}, onMove: (pose) => this.#draw(pose), onRest() {} });
  #motion = new Motion({ onMove: (sample) => this.#draw(sample) });

  constructor(state) {
    this.#state = state;
    this.#mechanism.mode = "move";
    this.#open();
  }

  async #open() {
    const { l1, at, cusp } = this.#state;
    document.querySelector(".player").hidden = Boolean(at);
    const answer = await answerTo(at ? posesOf(this.#state) : loopOf(this.#state, letterOf(cusp)));
    if (!answer) return;
    write("mechanism-count", at ? `L1 = ${l1}, L2 = ${at.l2}, L3 = ${at.l3}: pose ${at.pose + 1} of ${answer.count}` : `L1 = ${l1}: loop round cusp ${letterOf(cusp)}`);
    if (!at) this.#motion.show(answer);
    const pose = at ? answer.poses[at.pose] : this.#motion.samples[0];
    if (pose) this.#draw({ ...pose, l1: toNumber(l1) });
  }

  #draw(pose) {
    const { geometry } = this.#state;
    const { l1, l2, l3 } = this.#lengthsOf(pose);
    const poses = posesAt(geometry, { l1, l2, l3 });
    const own = nearestIn(poses, pose);
    const others = poses.map((other, k) => ({ ...other, name: k + 1 })).filter((_, k) => k !== own);
    this.#mechanism.draw(geometry, pose, others);
  }

  #lengthsOf(pose) {
    const [l1, l2, l3] = vectorOf(measured(this.#state.geometry), { ...pose, alpha_deg: Number(pose.alpha_deg), theta1_deg: Number(pose.theta1_deg) });
    return { l1, l2, l3 };
  }
}

function open() {
  const given = new URLSearchParams(location.hash.slice(1));
  const state = stateOf(location.hash);
  const range = (given.get("r") ?? "").split(",").map(toNumber);
  const isRange = range.length === 2 && range[0] > 0 && range[1] > range[0];
  if (!state || !(toNumber(state.l1) > 0)) return write("why-text", "This address has no manipulator: it ends in #g=…&l1=…, as a link of the explorer does.");
  const isMachine = given.get("v") === "mechanism";
  byId(isMachine ? "mechanism" : "slice").hidden = false; // a board measures its room
  if (isMachine) return new Machine(state);
  return new Slice(state, isRange ? range : null);
}

// a page that is scrolled by the wheel goes on over the picture; with Ctrl the wheel zooms, as a pinch does
on(window, "wheel", (event) => event.ctrlKey || event.stopImmediatePropagation(), { capture: true });
on(window, "hashchange", () => location.reload());
open();
