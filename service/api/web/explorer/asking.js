/** Asks what the page wants to know, and shows progress and what goes wrong. */

import { GoneError, ProblemError, ask, orNoAnswer } from "./api.js";
import { on } from "./dom.js";
import { Banner, Progress } from "./notices.js";

export class Asking {
  #progress = new Progress();
  #banner;
  #fields;
  #isCurrent;

  /** `fields` show the faults that are theirs, `isCurrent(state)` tells whether the page is still in a state. */
  constructor({ fields, isCurrent, onRetry }) {
    [this.#fields, this.#isCurrent] = [fields, isCurrent];
    this.#banner = new Banner({ onRetry });
    on(window, "pagehide", () => this.#progress.cancelAll());
    on("cancel", "click", () => {
      this.#progress.cancelAll();
      this.#banner.show(new Error("Cancelled."));
    });
  }

  cancel(...names) {
    for (const name of names) this.#progress.cancel(name);
  }

  clear() {
    this.#fields.clear();
    this.#banner.clear();
  }

  /**
   * The answer to a question `[path, question]` about a state; null without one, or if the page has gone on, unless
   * that `isLate` does not matter. `onRefusal(reason)` is told why there can be no answer; with `hasFields`, also what is
   * wrong with the question, whose fields the caller has.
   */
  async ask(name, state, [path, question], { onRefusal, isLate = false, hasFields = false, ...options } = {}) {
    const answer = await this.run(name, state, (follow) => ask(path, question, { ...follow, ...options }).catch((error) => {
      if (!onRefusal) throw error;
      const none = hasFields && error.status === 422 ? null : orNoAnswer(error);
      if (this.#isCurrent(state)) onRefusal(error.message);
      return none;
    }));
    return isLate || this.#isCurrent(state) ? answer : null;
  }

  /** Runs a task that gets `{signal, onProgress}`; null if it fails. */
  async run(name, state, task) {
    try {
      return await this.#progress.run(name, task);
    } catch (error) {
      if (error.name === "AbortError") return null;
      if (!(error instanceof ProblemError || error instanceof GoneError)) throw error;
      if (!this.#isCurrent(state) && !(error instanceof GoneError)) return null;
      const others = error instanceof ProblemError ? this.#fields.refuse(error.fields) : [];
      if (!error.fields?.length || others.length > 0) this.#banner.show(error, others);
      return null;
    }
  }
}
