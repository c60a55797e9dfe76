/** Steps back and forth: each state in which the page comes to rest is one of the browser's history. */

import { byId, on } from "./dom.js";

const SAME = 3000; // ms within which changes by one control are one step

export class Steps {
  #last = { control: null, time: -Infinity };
  #top = 0; // the number of the newest step

  /** `onGo(hash)` is told the address to which somebody has gone. */
  constructor({ onGo }) {
    this.#top = this.#at;
    on("undo", "click", () => history.back());
    on("redo", "click", () => history.forward());
    on(window, "popstate", () => {
      if (history.state === null) this.#write("replaceState", this.#top + 1); // an address that was entered, or a link
      this.#last = { control: null, time: -Infinity };
      this.#show();
      onGo(location.hash);
    });
    on(document, "keydown", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      if (event.target.matches("input:not([type=range], [type=radio])")) return; // which has an undo of its own
      const to = { z: event.shiftKey ? 1 : -1, y: 1 }[event.key.toLowerCase()];
      if (!to || (to < 0 ? byId("undo").disabled : byId("redo").disabled)) return;
      event.preventDefault();
      history.go(to);
    });
    this.#show();
  }

  get #at() {
    return history.state?.step ?? 0;
  }

  /** Takes the address of a state: a new step, unless it amends the last one, or the same control has just made that. */
  take(hash, isAmended = false) {
    if (hash === location.hash && history.state) return;
    const [control, time] = [document.activeElement, performance.now()];
    const isSame = control === this.#last.control && control !== document.body && time - this.#last.time < SAME;
    this.#last = { control, time };
    if (!history.state || isSame || isAmended) this.#write("replaceState", this.#at, hash);
    else this.#write("pushState", this.#at + 1, hash);
    this.#show();
  }

  #write(method, step, hash = location.hash) {
    history[method]({ step }, "", hash);
    this.#top = method === "pushState" ? step : Math.max(this.#top, step);
  }

  #show() {
    byId("undo").disabled = this.#at <= 0;
    byId("redo").disabled = this.#at >= this.#top;
  }
}
