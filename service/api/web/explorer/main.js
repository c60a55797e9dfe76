/** The page: one state, the regions that show it, and the questions that it asks. */

import "./theme.js";
import { GoneError, Latest, ProblemError, ask, orNoAnswer } from "./api.js";
import { Calls } from "./calls.js";
import { CensusStrip, counted } from "./census.js";
import { Exactness } from "./exactness.js";
import { Fields, firstExample } from "./form.js";
import { legendOf, showLegend, sliceOf } from "./curves.js";
import { Improve } from "./improve.js";
import { JointSpace, spoken } from "./joint_space.js";
import { JointLimits } from "./limits.js";
import { Mechanism } from "./mechanism.js";
import { Motion } from "./motion.js";
import { Banner, Progress, say } from "./notices.js";
import { bindPanel, notice, reveal } from "./panel.js";
import { Poses } from "./poses.js";
import { Save } from "./save.js";
import { faultOf, geometryText, hashOf, letterOf, stateOf } from "./state.js";
import { Steps } from "./steps.js";
import { CuspTable, copy } from "./table.js";

const REST = 300; // ms without a change after which the page asks for the rest
const [WHILE_MOVING, AT_REST] = [15, 30]; // digits
const COARSE = "0.003"; // tolerance of the curves while something moves
const TOLERANCES = [[0, "0.001"], [4, "0.0001"], [40, "0.00001"], [400, "0.000001"]]; // by magnification
const SAMPLES = 201; // of a loop
const byId = (id) => document.getElementById(id);

class Explorer {
  #state;
  #curves = null; // the singular curves that are drawn
  #slice = null; // the slice that is drawn, perhaps of a state that has passed
  #census = null; // the geometry whose census is drawn
  #poseTable = null; // the poses that are drawn, perhaps of a state that has passed
  #tolerance = TOLERANCES[0][1];
  #timer = null;

  #progress = new Progress();
  #banner = new Banner({ onRetry: () => this.#settle() });
  #fields = new Fields({ onChange: (change, isExample) => this.#change(change, isExample) });
  #mechanism = new Mechanism({ onDrag: (geometry) => this.#change({ geometry }), onRest: () => this.#draw() });
  #strip = new CensusStrip({ onChange: (l1) => this.#change({ l1 }) });
  #joint = new JointSpace({
    onSelect: (index) => this.#select(index),
    onVisit: (index) => this.#visit(index),
    onPick: (vector) => this.#pick(vector),
    onLimits: (limits) => this.#limit(limits),
    onZoom: (factor) => this.#refine(factor),
  });
  #table = new CuspTable({ onSelect: (index) => this.#select(index), say });
  #motion = new Motion({ onMove: (sample) => this.#move(sample) });
  #poses = new Poses({ onPick: (vector) => this.#pick(vector), onChoose: (pose) => this.#choosePose(pose) });
  #exactness = new Exactness({
    onAsk: (tolerance) => this.#askMargin(tolerance),
    onOpen: (geometry) => this.#change({ geometry, at: null }, true),
  });
  #improve = new Improve({
    onAsk: () => this.#askDesign(),
    onShow: (geometry) => {
      if (geometry) reveal("mechanism");
      this.#mechanism.drawCandidate(geometry);
    },
    onOpen: (geometry) => this.#change({ geometry, at: null }, true),
  });
  #limits = new JointLimits({
    onChange: (limits) => this.#limit(limits),
    onDraw: (isDrawing) => {
      if (isDrawing) {
        this.#view("joint");
        reveal("slice");
      }
      this.#joint.isDrawing = isDrawing;
    },
    onAsk: () => this.#askModes(),
  });
  #calls = new Calls();
  #save = new Save({ say });
  #panel = bindPanel();
  #steps = new Steps({ onGo: (hash) => this.#go(hash) });
  #live = new Latest((state) => this.#askPicture(state));

  open() {
    const fault = location.hash.length > 1 && !stateOf(location.hash) ? faultOf(location.hash) : "";
    this.#state = stateOf(location.hash) ?? { ...firstExample(), view: "joint" };
    notice(fault);
    this.#show();
    this.#joint.drawLimits(this.#state.limits);
    this.#settle();
    for (const radio of document.querySelectorAll("input[name=view]")) {
      radio.addEventListener("change", () => this.#view(radio.value));
    }
    byId("copy-link").addEventListener("click", () => copy(location.href, "The link is copied.", say));
    byId("copy-code").addEventListener("click", () => copy(this.#calls.text, "The call is copied.", say));
    window.addEventListener("pagehide", () => this.#progress.cancelAll());
    byId("cancel").addEventListener("click", () => {
      this.#progress.cancelAll();
      this.#banner.show(new Error("Cancelled."));
    });
  }

  /** Goes to the state of an address, to which somebody has stepped or which was entered. */
  #go(hash) {
    const state = stateOf(hash);
    notice(state ? "" : faultOf(hash).replace("The first example is shown.", "The picture is as it was."));
    if (!state || hashOf(state) === hashOf(this.#state)) return;
    this.#change(state, geometryText(state.geometry) !== geometryText(this.#state.geometry));
    this.#joint.drawLimits(state.limits);
    this.#view(state.view, false);
  }

  /** Takes a change of geometry or L1: asks for the slice at once, and for the rest when it has come to rest. */
  #change(change, isWhole = false) {
    if (change.geometry) {
      this.#progress.cancel("census");
      this.#progress.cancel("design");
      this.#improve.clear();
    }
    this.#progress.cancel("loop");
    this.#progress.cancel("margin");
    this.#exactness.clear();
    this.#clearLoop();
    this.#state = { ...this.#state, ...change };
    if (isWhole) this.#joint.fitNext();
    if (this.#state.at) {
      this.#poses.wait();
      this.#mechanism.drawGhosts([]);
    } else this.#poseTable = null;
    this.#show();
    clearTimeout(this.#timer);
    if (this.#isWrong()) return;
    this.#live.push(this.#state);
    this.#timer = setTimeout(() => this.#settle(), REST);
  }

  /** Whether fields of the state are wrong, each of which says so; then nothing is asked. */
  #isWrong() {
    const faults = Fields.faultsOf(this.#state);
    if (faults.length > 0) this.#fields.refuse(faults);
    this.#block(faults.length > 0);
    return faults.length > 0;
  }

  /** Dims what is not about the state, as long as it has no answer. */
  #block(isWrong) {
    Save.block(isWrong);
    for (const id of ["slice", "census", "table", "poses"]) byId(id).classList.toggle("wrong", isWrong);
    if (isWrong) byId("window").textContent = "";
  }

  #show() {
    const { geometry, l1, view } = this.#state;
    this.#fields.show(this.#state);
    this.#strip.show(l1);
    this.#improve.propose(l1);
    this.#poses.show(this.#state.at);
    byId(`view-${view}`).checked = true;
    byId("slice").classList.add("stale");
    if (this.#census !== geometryText(geometry)) byId("census").classList.add("stale");
    if (!this.#mechanism.isHeld) this.#draw(); // else it has drawn itself
  }

  /** Asks for everything about the state in which the page has come to rest. */
  async #settle() {
    const state = this.#state;
    this.#live.drop();
    this.#tell();
    if (this.#isWrong()) return;
    this.#table.link(state.geometry, state.l1, AT_REST);
    const [isDone] = await Promise.all([this.#askSlice(state), this.#askCurves(state)]);
    if (!isDone || !this.#isCurrent(state)) return; // first the picture, before a worker is busy for longer
    await this.#askPoses();
    await this.#askLoop();
    if (this.#isCurrent(state)) await this.#askCensus(state);
  }

  /** Whether the page still asks what it asked in a state. */
  #isCurrent({ geometry, l1 }) {
    return l1 === this.#state.l1 && geometryText(geometry) === geometryText(this.#state.geometry);
  }

  /** Asks for the whole picture in one question, as long as something moves. */
  #askPicture(state) {
    const { geometry, l1 } = state;
    return this.#asking("slice", state, async (signal, onProgress) => {
      const question = { geometry, l1, digits: WHILE_MOVING, tolerance: COARSE };
      const curves = await ask("v1/singular-curves", question, { signal, onProgress }).catch(orNoAnswer);
      if (!curves) return; // when all is at rest, the page says why
      this.#showCurves(curves);
      return this.#showSlice(state, sliceOf(curves, l1));
    });
  }

  #askSlice(state) {
    const { geometry, l1 } = state;
    return this.#asking("slice", state, async (signal, onProgress) => {
      const table = await ask("v1/cusp-tables", { geometry, l1, digits: AT_REST }, { signal, onProgress });
      this.#showSlice(state, table.slices[0]);
    });
  }

  #askCurves(state) {
    const { geometry, l1 } = state;
    return this.#asking("curves", state, async (signal, onProgress) => {
      let reason = "";
      const question = { geometry, l1, tolerance: this.#tolerance };
      const curves = await ask("v1/singular-curves", question, { signal, onProgress }).catch((error) => {
        reason = error.message;
        return orNoAnswer(error);
      });
      if (!this.#isCurrent(state)) return;
      if (curves) this.#showCurves(curves);
      else this.#lack(reason);
    });
  }

  /** Asks for finer curves if the picture is magnified, so that they stay smooth. */
  #refine(factor) {
    const tolerance = TOLERANCES.findLast(([least]) => factor >= least)?.[1] ?? TOLERANCES[0][1];
    if (tolerance === this.#tolerance) return;
    this.#tolerance = tolerance;
    this.#askCurves(this.#state);
  }

  #showCurves(curves) {
    this.#curves = curves;
    this.#lack("");
    this.#joint.drawCurves(curves, this.#state.view);
    this.#poses.offer(curves, this.#state.at);
    showLegend(legendOf(curves, this.#state.view));
  }

  /** Keeps the last picture, dimmed, and says why this slice has none. */
  #lack(reason) {
    byId("slice").classList.toggle("unanswered", Boolean(reason));
    byId("why").hidden = !reason;
    byId("why-text").textContent = reason && `L1 = ${this.#state.l1} has no picture. ${inPlainWords(reason)}`;
    byId("why-detail").textContent = reason && `The service says: ${reason}`;
  }

  #showSlice(state, slice) {
    this.#slice = slice;
    this.#fields.clear();
    this.#block(false);
    this.#banner.clear();
    byId("slice").classList.toggle("stale", !this.#isCurrent(state));
    if (slice.error) this.#fields.refuse([{ field: "l1", message: slice.error.detail }]);
    const length = Object.assign(document.createElement("span"), { textContent: `L1 = ${slice.l1}: ` });
    byId("count").replaceChildren(length, slice.error ? "no answer" : counted(slice.count));
    if (!this.#mechanism.isHeld) say(byId("count").textContent);
    if (!slice.error) this.#joint.draw(slice, this.#state.view, this.#selected);
    this.#table.draw(slice, this.#selected);
    this.#limits.show(this.#state.limits, slice.cusps);
    this.#visit(this.#selected);
    if (!this.#mechanism.isHeld) this.#draw();
    document.body.dataset.pictures = Number(document.body.dataset.pictures ?? 0) + 1;
  }

  /** Asks for the loop round the selected cusp. */
  async #askLoop() {
    const state = this.#state;
    this.#clearLoop();
    if (!this.#cusp) return false;
    const question = { geometry: state.geometry, l1: state.l1, cusp: letterOf(this.#selected), samples: SAMPLES, digits: WHILE_MOVING };
    return this.#asking("loop", state, async (signal, onProgress) => {
      const path = await ask("v1/paths", question, { signal, onProgress }).catch((error) => {
        this.#motion.show(null, error.message);
        return orNoAnswer(error);
      });
      if (!path) return;
      this.#motion.show(path);
      this.#joint.drawLoop(this.#motion.samples);
      this.#drawGhosts();
    });
  }

  /** Takes a joint vector, and asks for its poses. */
  #pick(vector) {
    this.#motion.pause();
    this.#state = { ...this.#state, at: { ...vector, pose: 0 } };
    this.#poses.show(this.#state.at);
    this.#poses.wait();
    this.#drawPoses();
    this.#tell();
    return this.#askPoses();
  }

  #choosePose(pose) {
    this.#motion.pause();
    this.#state = { ...this.#state, at: { ...this.#state.at, pose } };
    this.#tell();
    this.#drawPoses();
  }

  /** Leaves the joint vector for a cusp or its loop. */
  #leavePoses() {
    if (!this.#state.at) return;
    this.#state = { ...this.#state, at: null };
    this.#poseTable = null;
    this.#poses.show(null);
    this.#tell();
    this.#drawPoses();
  }

  async #askPoses() {
    const state = this.#state;
    const { geometry, l1, at } = state;
    if (!at) return;
    await this.#asking("poses", state, async (signal, onProgress) => {
      const question = { geometry, l1, l2: at.l2, l3: at.l3, digits: WHILE_MOVING };
      const table = await ask("v1/poses", question, { signal, onProgress });
      const now = this.#state.at;
      if (!this.#isCurrent(state) || now?.l2 !== at.l2 || now.l3 !== at.l3) return;
      const pose = Math.min(now.pose, Math.max(table.count - 1, 0));
      this.#state = { ...this.#state, at: { ...now, pose } };
      this.#fields.clear();
      this.#poseTable = table;
      this.#poses.draw(table, pose);
      say(byId("pose-count").textContent);
      this.#drawPoses();
    });
  }

  #drawPoses() {
    this.#joint.drawPoses(this.#state.at, this.#poseTable?.poses ?? []);
    this.#draw();
    this.#drawGhosts();
  }

  /** Draws outlines: of the other poses of the joint vector, or of both ends of the loop. */
  #drawGhosts() {
    const { at, l1 } = this.#state;
    const others = (this.#poseTable?.poses ?? []).filter((_, k) => k !== at?.pose).map((pose) => placed(pose, l1));
    const ends = [this.#motion.samples.at(0), this.#motion.samples.at(-1)].filter(Boolean);
    const numbers = (this.#poseTable?.poses ?? []).map((_, k) => String(k + 1)).filter((_, k) => k !== at?.pose);
    this.#mechanism.drawGhosts(at ? others : ends, at ? numbers : this.#motion.ends);
  }

  #clearLoop() {
    if (this.#motion.samples.length === 0) return this.#motion.show(null);
    this.#motion.show(null);
    this.#joint.drawLoop([]);
    return this.#drawGhosts();
  }

  /** Shows the manipulator on its way round the cusp. */
  #move(sample) {
    this.#leavePoses();
    this.#mechanism.draw(this.#state.geometry, sample);
    this.#joint.mark(sample);
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

  /** Asks whether the slice keeps its number of cusps within a tolerance. */
  #askMargin(tolerance) {
    const state = this.#state;
    const { geometry, l1 } = state;
    this.#tell();
    return this.#asking("margin", state, async (signal, onProgress) => {
      const margin = await ask("v1/margins", { geometry, l1, tolerance }, { signal, onProgress }).catch((error) => {
        this.#exactness.refuse(error.message);
        return orNoAnswer(error);
      });
      if (margin && this.#isCurrent(state)) this.#exactness.show(margin, l1, tolerance);
    });
  }

  /** Takes joint limits, or null for none. */
  #limit(limits) {
    this.#state = { ...this.#state, limits };
    this.#limits.show(limits, this.#slice?.cusps);
    this.#joint.drawLimits(limits);
    if (limits) this.#limits.draws(false);
    this.#tell();
  }

  /** Asks whether the assembly mode can change within the limits. */
  #askModes() {
    const state = this.#state;
    const { geometry, l1, limits } = state;
    return this.#asking("assembly modes", state, async (signal, onProgress) => {
      const question = { geometry, l1, ...(limits ? { limits } : {}) };
      const modes = await ask("v1/assembly-modes", question, { signal, onProgress }).catch((error) => {
        this.#limits.tell(error.message);
        return orNoAnswer(error);
      });
      if (modes && this.#isCurrent(state)) this.#limits.tell(modes);
    });
  }

  #askDesign() {
    const state = this.#state;
    this.#tell();
    return this.#asking("design", state, (...follow) => this.#improve.ask(state.geometry, ...follow));
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

  /** Selects a cusp, and plays the loop round it. */
  async #select(index) {
    this.#leavePoses();
    this.#state = { ...this.#state, cusp: index };
    this.#tell();
    this.#joint.select(index);
    this.#table.select(index);
    this.#visit(index);
    this.#draw();
    if (await this.#askLoop()) this.#motion.playUnlessCalm();
  }

  /** The number of the selected cusp: the last if there are fewer. */
  get #selected() {
    return Math.min(this.#state.cusp, Math.max((this.#slice?.cusps ?? []).length - 1, 0));
  }

  get #cusp() {
    return this.#slice?.cusps?.[this.#selected];
  }

  /** Tells of a cusp that is looked at. */
  #visit(index) {
    const cusp = this.#slice?.cusps?.[index];
    byId("visited").textContent = cusp ? spoken(cusp, index) : "";
  }

  #view(view, isStep = true) {
    this.#state = { ...this.#state, view };
    byId(`view-${view}`).checked = true;
    if (isStep) this.#tell();
    if (!this.#slice) return;
    this.#joint.draw(this.#slice, view, this.#selected);
    this.#joint.drawLoop(this.#motion.samples);
    this.#joint.drawPoses(this.#state.at, this.#poseTable?.poses ?? []);
    showLegend(legendOf(this.#curves, view));
  }

  /** Draws the manipulator at the chosen pose, or at the selected cusp. */
  #draw() {
    const { geometry, l1, at } = this.#state;
    const shown = (at && this.#poseTable?.poses[at.pose]) ?? this.#cusp;
    this.#mechanism.draw(geometry, shown ? placed(shown, l1) : { alpha: 0, theta1: 60, l1 });
  }

  /** Writes the state into the address and the calls. */
  #tell() {
    this.#steps.take(hashOf(this.#state));
    this.#save.show(this.#state);
    this.#calls.show({ ...this.#state, tolerance: this.#exactness.tolerance, wish: this.#improve.members });
  }
}

const REASONS = [
  [/every pose of this slice is singular/, "Every pose of this length is singular: the platform is nowhere held, so that there is no curve to draw."],
  [/whole lines? theta/, "The curve has whole lines on which leg 1 keeps its direction. They are not drawn."],
  [/double precision|told apart|do not close/, "Here curves lie so near to each other, or on each other, that a drawing cannot tell its regions apart. A length near by may have a picture."],
  [/not rational|repeated component/, "The curves of this slice lie on each other. They are not drawn."],
];

/** Why a slice has no picture, without the words of the solver. */
function inPlainWords(reason) {
  const words = REASONS.find(([pattern]) => pattern.test(reason))?.[1] ?? "This slice is of a special kind that cannot be drawn.";
  return `${words} Behind this is the last picture, dimmed; the table has what is known of this slice.`;
}

/** The angles of a pose as numbers. */
function placed(pose, l1) {
  return { alpha: Number(pose.alpha_deg), theta1: Number(pose.theta1_deg), l1 };
}

new Explorer().open();
