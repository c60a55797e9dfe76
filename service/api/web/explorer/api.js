/** Calls of the public API: questions, jobs with their progress, and what goes wrong. */

import { make, say } from "./dom.js";

const WAIT = 2; // seconds that an answer may take before it is a job to be followed
const PAUSE = 100; // ms between a stream of events and the state of the job
const KEY = "rpr-cusps-key";
const NO_ANSWER = "/problems/job-solver-error";

/** The service refused or failed; `problem` is its document (RFC 9457). */
export class ProblemError extends Error {
  constructor(status, problem, retryAfter) {
    super(problem.detail ?? problem.title ?? `The service answered with status ${status}.`);
    this.status = status;
    this.problem = problem;
    this.retryAfter = retryAfter;
  }

  get fields() {
    return this.problem.errors ?? [];
  }

  get isPassing() {
    return [429, 502, 503, 504].includes(this.status);
  }
}

/** That there is no answer is one, too, and is shown in its place; other errors go on. */
export function orNoAnswer(error) {
  if (error instanceof ProblemError && error.problem.type?.endsWith(NO_ANSWER)) return null;
  throw error;
}

/** The service cannot be reached. */
export class GoneError extends Error {}

const isFramed = "embedded" in document.documentElement.dataset; // a page that others may frame uses no key

/** The key for a service that asks for one; kept as long as this tab. */
export const key = {
  get: () => (isFramed ? "" : (sessionStorage.getItem(KEY) ?? "")),
  set: (text) => (text ? sessionStorage.setItem(KEY, text) : sessionStorage.removeItem(KEY)),
};

/** The address of a call, as other programs write it. */
export function address(path) {
  const base = new URL(".", document.baseURI); // links in answers have its path already, if a proxy adds one
  return new URL(path.startsWith(base.pathname) ? path.slice(base.pathname.length) : path.replace(/^\//, ""), base).href;
}

const early = new Map(); // responses to questions that were asked ahead
const kept = new Map(); // answers, the newest last
const MOST = 200;

function post(path, body, wait, signal) {
  const headers = { "Content-Type": "application/json", Prefer: wait ? `wait=${wait}` : "respond-async" };
  return call(path, { method: "POST", headers, body, signal });
}

/** Asks a question of which `ask` will take the response. */
export function begin(path, question) {
  const body = JSON.stringify(question);
  const response = post(path, body, WAIT);
  response.catch(() => {});
  early.set(path + body, response);
}

export async function call(path, { headers = {}, ...options } = {}) {
  const bearer = key.get() ? { Authorization: `Bearer ${key.get()}` } : {};
  let response;
  try {
    response = await fetch(address(path), { ...options, headers: { ...headers, ...bearer } });
  } catch (error) {
    throw error.name === "AbortError" ? error : new GoneError("The service cannot be reached.");
  }
  if (response.ok) return response;
  const problem = await response.json().catch((error) => {
    if (error.name === "AbortError") throw error;
    return { title: response.statusText };
  });
  throw new ProblemError(response.status, problem, Number(response.headers.get("Retry-After") ?? 0));
}

/** The answer to a question, if the page has it. */
export const known = ([path, question]) => kept.get(path + JSON.stringify(question));

/**
 * Asks a question, unless its answer is known; follows the job if there is one.
 * An abort by `signal` withdraws the question; `onProgress` gets the job's `{done, total}`, `onJob` the job
 * itself, and `onEvent` the name and the data of each of its events.
 */
export async function ask(path, question, { signal, wait = WAIT, ...told } = {}) {
  const body = JSON.stringify(question);
  const name = path + body;
  if (kept.has(name)) return kept.get(name);
  const begun = early.get(name);
  early.delete(name);
  const response = await (begun ?? post(path, body, wait, signal));
  let answer = await read(response);
  if (response.status === 202) answer = await result(answer, signal, told);
  if (wait) kept.set(name, answer); // what has been asked for at once is asked for again
  if (kept.size > MOST) kept.delete(kept.keys().next().value);
  return answer;
}

/** The answer to a question in another form than JSON: repeated, it does not compute it again. */
export async function fileOf([path, question], accept) {
  const headers = { "Content-Type": "application/json", Accept: accept, Prefer: "wait=30" };
  const options = { method: "POST", headers, body: JSON.stringify(question) };
  let response = await call(path, options);
  while (response.status === 202) response = await call(path, options);
  return response;
}

/** Saves something as a file. */
export function keep(blob, name) {
  const url = URL.createObjectURL(blob);
  make("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

/** Saves the answer to a question as a file. */
export async function save(question, accept, name) {
  try {
    keep(await (await fileOf(question, accept)).blob(), name);
  } catch (error) {
    say(error.message);
  }
}

async function result(job, signal, { onProgress = () => {}, onJob = () => {}, onEvent = () => {} }) {
  const withdraw = () => call(job.links.self, { method: "DELETE", keepalive: true }).catch(() => {});
  signal?.addEventListener("abort", withdraw, { once: true });
  try {
    onJob(job);
    onProgress(job.progress);
    const hear = (name, data) => {
      if (data.progress) onProgress(data.progress);
      onEvent(name, data);
    };
    while (!job.done) {
      await follow(job.links.events, signal, hear);
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
      job = await read(await call(job.links.self, { signal }));
    }
    return await read(await call(job.links.result, { signal }));
  } finally {
    signal?.removeEventListener("abort", withdraw);
  }
}

/** Reads server-sent events to the end of the stream; by fetch, since an EventSource sends no key. */
async function follow(path, signal, onEvent) {
  const response = await call(path, { headers: { Accept: "text/event-stream" }, signal });
  if (!response.body) return;
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  try {
    for (let text = ""; ; ) {
      const { value, done } = await reader.read();
      if (done) return;
      const events = (text + value).split(/\r?\n\r?\n/);
      text = events.pop();
      for (const event of events) {
        const data = event.match(/^data: ?(.*)$/m)?.[1];
        if (data) onEvent(event.match(/^event: ?(.*)$/m)?.[1], JSON.parse(data));
      }
    }
  } catch (error) {
    if (error.name === "AbortError") throw error; // a stream that breaks is no harm: the job is asked again
  }
}

async function read(response) {
  try {
    return await response.json();
  } catch (error) {
    throw error.name === "AbortError" ? error : new GoneError("The answer of the service was interrupted.");
  }
}
