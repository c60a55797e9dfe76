/** What the page says: progress, what went wrong, and short news for screen readers. */

import { GoneError, ProblemError, call, key } from "./api.js";
import { byId, on, say, write } from "./dom.js";

/** The line about a special shape nearby that contradicts or weakens an answer; empty without one. */
export function nearText(shape) {
  return shape ? `Within ${shape.distance} of a special shape: ${shape.says}. The answers shown are proved for the numbers as entered.` : "";
}

/** The special shape near the geometry of an answer that contradicts or weakens it. */
export function nearOf({ near = [] }) {
  return near.find(({ effect }) => effect !== "harmless");
}

const LONGEST = 10; // seconds between attempts to reach the service

/** The progress of jobs by name, each of which can be cancelled. */
export class Progress {
  #jobs = new Map();

  /** Runs a task that gets `{signal, onProgress}`; a number after the name is not shown. */
  async run(name, task) {
    this.cancel(name);
    const job = { controller: new AbortController(), done: 0, total: 0 };
    this.#jobs.set(name, job);
    const late = setTimeout(() => this.#show(), 250); // what is quick needs no bar
    try {
      const onProgress = ({ done, total }) => {
        Object.assign(job, { done, total });
        this.#show();
      };
      return await task({ signal: job.controller.signal, onProgress });
    } finally {
      clearTimeout(late);
      if (this.#jobs.get(name) === job) this.#jobs.delete(name);
      this.#show();
    }
  }

  cancel(name) {
    this.#jobs.get(name)?.controller.abort();
    this.#jobs.delete(name);
  }

  cancelAll() {
    for (const name of [...this.#jobs.keys()]) this.cancel(name);
    this.#show();
  }

  #show() {
    const [name, job] = [...this.#jobs].at(-1) ?? [];
    byId("progress").hidden = !job;
    if (!job) return;
    const bar = byId("bar");
    write("progress-text", `Computing the ${name.replace(/ \d$/, "")}`);
    if (job.total > 1) {
      bar.max = job.total;
      bar.value = job.done;
    } else bar.removeAttribute("value");
  }
}

/** The banner for what went wrong; it comes back to the questions by itself where that may help. */
export class Banner {
  #timer = null;
  #attempt = 0;
  #onRetry;

  constructor({ onRetry }) {
    this.#onRetry = onRetry;
    on("retry", "click", () => this.#retry());
    on("key-form", "submit", () => {
      key.set(byId("key").value.trim());
      byId("key").value = "";
      this.#retry();
    });
  }

  show(error, others = []) {
    const isGone = error instanceof GoneError;
    const asksForKey = error instanceof ProblemError && [401, 403].includes(error.status);
    const more = others.map(({ field, message }) => `${field} ${message}`);
    const text = [isGone ? "The service cannot be reached." : error.message, ...more].join(" ");
    write("banner-text", text);
    byId("banner").hidden = false;
    byId("banner").classList.toggle("gone", isGone);
    byId("key-form").hidden = !asksForKey;
    byId("retry").hidden = asksForKey;
    if (asksForKey && error.status === 401) byId("key").focus();
    if (isGone || error.isPassing) this.#plan(error.retryAfter ?? 0);
  }

  clear() {
    clearTimeout(this.#timer);
    this.#attempt = 0;
    if (byId("banner").hidden) return;
    if (byId("banner").classList.contains("gone")) say("The service is back.");
    byId("banner").hidden = true;
    write("banner-text", "");
  }

  #plan(retryAfter) {
    clearTimeout(this.#timer);
    const seconds = Math.max(retryAfter, Math.min(2 ** this.#attempt, LONGEST));
    this.#attempt += 1;
    write("banner-next", `Trying again in ${seconds} s.`);
    this.#timer = setTimeout(() => this.#probe(), seconds * 1000);
  }

  async #probe() {
    try {
      await call("healthz");
    } catch (error) {
      if (error instanceof GoneError) return this.#plan(0);
    }
    return this.#onRetry();
  }

  #retry() {
    clearTimeout(this.#timer);
    write("banner-next", "");
    this.#onRetry();
  }
}
