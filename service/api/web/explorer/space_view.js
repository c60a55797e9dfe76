/** The picture "space": its modules, and the library that draws it, are loaded when somebody opens it. */

import { byId, on, say } from "./dom.js";

const ZOOM = 1.6;

export class SpaceView {
  #told;
  #picture = null; // a promise of it
  #shown = {}; // what it shows, or will
  isOpen = false;

  /** `told` is what `Space` tells and asks. */
  constructor(told) {
    this.#told = told;
    const actions = { in: ZOOM, out: 1 / ZOOM, all: null };
    for (const [name, factor] of Object.entries(actions)) on(`zoom-${name}`, "click", (event) => this.#zoom(event, factor), true);
  }

  async #zoom(event, factor) {
    if (!this.isOpen) return;
    event.stopImmediatePropagation(); // else the board behind it would be zoomed
    (await this.#picture)?.zoom(factor);
  }

  /** Opens or closes the picture. */
  open(isOpen) {
    byId("slice").dataset.view = isOpen ? "space" : "flat";
    this.isOpen = isOpen;
    if (isOpen) this.#fill();
  }

  /** Takes what there is to see: `{geometry, l1, slice, curves, selected, path, here, limits, at, eye}`. */
  set(shown) {
    Object.assign(this.#shown, shown);
    if (this.isOpen) this.#fill();
  }

  async #fill() {
    this.#picture ??= this.#load();
    const picture = await this.#picture;
    if (this.isOpen) picture?.set(this.#shown);
  }

  async #load() {
    try {
      const { Space } = await import("../space/space.js");
      return new Space(byId("space"), this.#told);
    } catch (error) {
      say(`The picture in three dimensions cannot be loaded: ${error.message}`);
      this.#picture = null;
      return null;
    }
  }

  /** The picture on a canvas, or null. */
  async image() {
    return (await this.#picture)?.image() ?? null;
  }
}
