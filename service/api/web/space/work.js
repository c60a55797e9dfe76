/** What the worker computes: of each task only the newest that waits. */

export class Work {
  #worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  #number = 0;
  #running = null; // {number, resolve}
  #waiting = new Map(); // by task

  constructor() {
    this.#worker.onmessage = ({ data: { number, answer, error } }) => {
      if (this.#running?.number !== number) return;
      if (error) console.error(error);
      this.#running.resolve(answer ?? null);
      this.#running = null;
      this.#next();
    };
  }

  /** The answer to a task; null if it fails, or a newer one of its kind has overtaken it. */
  ask(task, rest) {
    return new Promise((resolve) => {
      this.#waiting.get(task)?.resolve(null);
      this.#waiting.set(task, { message: { task, ...rest }, resolve });
      this.#next();
    });
  }

  #next() {
    const [task, next] = this.#waiting.entries().next().value ?? [];
    if (this.#running || !next) return;
    this.#waiting.delete(task);
    this.#number += 1;
    this.#running = { number: this.#number, resolve: next.resolve };
    this.#worker.postMessage({ number: this.#number, ...next.message });
  }
}
