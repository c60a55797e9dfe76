/** The page: one state, the regions that show it, and the questions that it asks. */

import "./theme.js";
import { GoneError, Latest, ProblemError, ask } from "./api.js";
import { Calls } from "./calls.js";
import { CensusStrip, counted } from "./census.js";
import { Fields, firstExample } from "./form.js";
import { JointSpace, spoken } from "./joint_space.js";
import { Mechanism } from "./mechanism.js";
import { Banner, Progress, say } from "./notices.js";
import { geometryText, hashOf, stateOf } from "./state.js";
import { CuspTable, copy } from "./table.js";

const REST = 300; // ms without a change after which the page asks for the rest
const [WHILE_MOVING, AT_REST] = [15, 30]; // digits
const byId = (id) => document.getElementById(id);

class Explorer {
  #state;
  #slice = null; // the slice that is drawn, perhaps of a state that has passed
  #census = null; // the geometry whose census is drawn
  #timer = null;
  #isFitted = false;

  #progress = new Progress();
  #banner = new Banner({ onRetry: () => this.#settle() });
  #fields = new Fields({ onChange: (change, isExample) => this.#change(change, isExample) });
  #mechanism = new Mechanism({ onDrag: (geometry) => this.#change({ geometry }), onRest: () => this.#draw() });
  #strip = new CensusStrip({ onChange: (l1) => this.#change({ l1 }) });
  #joint = new JointSpace({ onSelect: (index) => this.#select(index), onVisit: (index) => this.#visit(index) });
  #table = new CuspTable({ onSelect: (index) => this.#select(index), say });
  #calls = new Calls();
  #live = new Latest((state) => this.#askSlice(state, WHILE_MOVING));

  open() {
    this.#state = stateOf(location.hash) ?? { ...firstExample(), view: "joint" };
    this.#show();
    this.#settle();
    window.addEventListener("hashchange", () => {
      const state = stateOf(location.hash);
      if (state && hashOf(state) !== hashOf(this.#state)) this.#change(state, true);
    });
    for (const radio of document.querySelectorAll("input[name=view]")) {
      radio.addEventListener("change", () => this.#view(radio.value));
    }
    byId("copy-link").addEventListener("click", () => copy(location.href, "The link is copied.", say));
    byId("copy-code").addEventListener("click", () => copy(this.#calls.text, "The call is copied.", say));
    byId("cancel").addEventListener("click", () => {
      this.#progress.cancelAll();
      this.#banner.show(new Error("Cancelled."));
    });
  }

  /** Takes a change of geometry or L1: asks for the slice at once, and for the rest when it has come to rest. */
  #change(change, isWhole = false) {
    if (change.geometry) this.#progress.cancel("census");
    this.#state = { ...this.#state, ...change };
    this.#isFitted ||= isWhole;
    this.#show();
    this.#live.push(this.#state);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#settle(), REST);
  }

  #show() {
    const { geometry, l1, view } = this.#state;
    this.#fields.show(this.#state);
    this.#strip.show(l1);
    byId(`view-${view}`).checked = true;
    byId("slice").classList.add("stale");
    if (this.#census !== geometryText(geometry)) byId("census").classList.add("stale");
    this.#draw();
  }

  /** Asks for everything about the state in which the page has come to rest. */
  async #settle() {
    const state = this.#state;
    this.#live.drop();
    history.replaceState(null, "", hashOf(state));
    this.#calls.show(state.geometry, state.l1);
    this.#table.link(state.geometry, state.l1, AT_REST);
    const isDone = await this.#askSlice(state, AT_REST); // first the picture, before a worker is busy for longer
    if (isDone && this.#isCurrent(state)) await this.#askCensus(state);
  }

  /** Whether the page still asks what it asked in a state. */
  #isCurrent({ geometry, l1 }) {
    return l1 === this.#state.l1 && geometryText(geometry) === geometryText(this.#state.geometry);
  }

  #askSlice(state, digits) {
    const { geometry, l1 } = state;
    return this.#asking("slice", state, async (signal, onProgress) => {
      const table = await ask("v1/cusp-tables", { geometry, l1, digits }, { signal, onProgress });
      this.#showSlice(state, table.slices[0]);
    });
  }

  #showSlice(state, slice) {
    this.#slice = slice;
    this.#fields.clear();
    this.#banner.clear();
    byId("slice").classList.toggle("stale", !this.#isCurrent(state));
    if (slice.error) this.#fields.refuse([{ field: "l1", message: slice.error.detail }]);
    byId("count").textContent = `L1 = ${slice.l1}: ${slice.error ? "no answer" : counted(slice.count)}`;
    if (!this.#mechanism.isHeld) say(byId("count").textContent);
    const cusp = Math.min(this.#state.cusp, Math.max((slice.cusps ?? []).length - 1, 0));
    this.#joint.draw(slice, this.#state.view, cusp, this.#isFitted);
    this.#table.draw(slice, cusp);
    this.#isFitted = false;
    this.#visit(cusp);
    this.#draw();
    document.body.dataset.pictures = Number(document.body.dataset.pictures ?? 0) + 1;
  }

  async #askCensus(state) {
    const text = geometryText(state.geometry);
    if (this.#census === text) return;
    await this.#asking("census", state, async (signal, onProgress) => {
      const question = { geometry: state.geometry, digits: WHILE_MOVING };
      const census = await ask("v1/censuses", question, { signal, onProgress, wait: 0 });
      this.#census = text;
      byId("census").classList.remove("stale");
      this.#strip.draw(census);
      this.#strip.show(this.#state.l1);
    });
  }

  /** Runs a question, and tells whether it was answered; what goes wrong is shown unless the page has gone on. */
  async #asking(name, state, task) {
    try {
      await this.#progress.run(name, task);
      return true;
    } catch (error) {
      if (error.name === "AbortError") return false;
      if (!(error instanceof ProblemError || error instanceof GoneError)) throw error;
      if (!this.#isCurrent(state) && !(error instanceof GoneError)) return false;
      const others = error instanceof ProblemError ? this.#fields.refuse(error.fields) : [];
      const isAtFields = error instanceof ProblemError && error.fields.length > 0 && others.length === 0;
      if (!isAtFields) this.#banner.show(error, others);
      return false;
    }
  }

  #select(index) {
    this.#state = { ...this.#state, cusp: index };
    history.replaceState(null, "", hashOf(this.#state));
    this.#joint.select(index);
    this.#table.select(index);
    this.#visit(index);
    this.#draw();
  }

  /** Tells of a cusp that is looked at. */
  #visit(index) {
    const cusp = this.#slice?.cusps?.[index];
    byId("visited").textContent = cusp ? spoken(cusp, index) : "";
  }

  #view(view) {
    this.#state = { ...this.#state, view };
    history.replaceState(null, "", hashOf(this.#state));
    if (this.#slice) this.#joint.draw(this.#slice, view, this.#state.cusp, true);
  }

  /** Draws the manipulator at the selected cusp. */
  #draw() {
    const { geometry, l1, cusp } = this.#state;
    const cusps = this.#slice?.cusps ?? [];
    const at = cusps[Math.min(cusp, cusps.length - 1)];
    const pose = at ? { alpha: Number(at.alpha_deg), theta1: Number(at.theta1_deg) } : { alpha: 0, theta1: 60 };
    this.#mechanism.draw(geometry, { ...pose, l1 });
  }
}

new Explorer().open();
