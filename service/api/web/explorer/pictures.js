/** Pictures while something moves: of the newest state, or of those to which L1 slides. */

import { ask, known } from "./api.js";
import { sliceOf } from "./curves.js";
import { toNumber } from "./decimals.js";
import { pictureOf } from "./questions.js";

const [MOST, LEAD] = [14, 3]; // frames asked for on either side before a slide, and ahead for each step
const SLIDE = 200; // ms between its steps

export class Pictures {
  #page;
  #next = null; // the state that is asked for next
  #free = [0, 1, 2]; // lanes, in each of which one is asked for
  #under = new Set(); // their lengths
  #asked = 0; // pictures so far
  #drawn = 0; // number of the newest that was drawn
  #last = 0; // when something moved

  constructor(page) {
    this.#page = page;
  }

  /** Asks on both sides of the slice before a slide. */
  prepare() {
    const { state, strip } = this.#page;
    [1, -1].forEach(async (side) => {
      for (let k = 1; k <= MOST && state === this.#page.state; k += 1) {
        const l1 = strip.ahead(side * k);
        if (l1) await ask(...pictureOf({ ...state, l1 })).catch(() => {});
      }
    });
  }

  /** Takes a change of state, by so many steps of the slider. */
  move(by) {
    const { state, isShown } = this.#page;
    const [curves, isSlide] = [known(pictureOf(state)), performance.now() - this.#last < SLIDE];
    this.#last = performance.now();
    if (curves && !isShown) this.#show(state, curves);
    const l1 = isSlide && this.#ahead(by);
    if (l1 || !curves) this.#push(l1 ? { ...state, l1 } : state);
  }

  drop() {
    this.#next = null;
  }

  /** A length that is not known, to which a slide comes. */
  #ahead(by) {
    const { state, strip } = this.#page;
    let [frames, l1] = [LEAD * by, null];
    if (!by || Math.abs(frames) > MOST) return null;
    do l1 = strip.ahead((frames += Math.sign(by)));
    while (l1 && (this.#under.has(l1) || known(pictureOf({ ...state, l1 }))));
    return l1;
  }

  async #push(state) {
    this.#next = state;
    const lane = this.#free.pop();
    if (lane === undefined) return;
    while (this.#next) await this.#ask(this.#next, lane);
    this.#free.push(lane);
  }

  async #ask(state, lane) {
    this.#next = null;
    const number = (this.#asked += 1);
    this.#under.add(state.l1);
    const told = { onRefusal() {}, isLate: true }; // at rest the page says why
    const curves = await this.#page.asking.ask(`slice ${lane}`, state, pictureOf(state), told);
    this.#under.delete(state.l1);
    const { state: now, shown } = this.#page;
    const far = ({ l1 }) => Math.abs(toNumber(l1) - toNumber(now.l1));
    const isNearer = shown?.geometry !== state.geometry || far(state) < far(shown);
    if (!curves || number < this.#drawn || !isNearer) return;
    this.#drawn = number;
    this.#show(state, curves);
  }

  #show(state, curves) {
    this.#page.take({ state, slice: sliceOf(curves, state.l1), curves });
  }
}
