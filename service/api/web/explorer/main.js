/** The page: one state, the regions that show it, and what follows from a change. */

import { Asking } from "./asking.js";
import { Calls } from "./calls.js";
import { CensusStrip } from "./census.js";
import { legendOf, showLegend } from "./curves.js";
import { byId, on, say, write } from "./dom.js";
import { decimal, shortened, toNumber } from "./decimals.js";
import { Exactness } from "./exactness.js";
import { Fields, firstExample } from "./form.js";
import { Following, fateOf } from "./following.js";
import { isSix, measured, pairOf, placesOf } from "./geometry.js";
import { Improve } from "./improve.js";
import { JointSpace, spoken } from "./joint_space.js";
import { nearestIn, vectorOf } from "./kinematics.js";
import { JointLimits, isWithin } from "./limits.js";
import { Mechanism } from "./mechanism.js";
import { posesAt, vectorNear } from "./merging.js";
import { Motion } from "./motion.js";
import { nearOf, nearText } from "./notices.js";
import { bindPanel, notice } from "./panel.js";
import { Pictures } from "./pictures.js";
import { Poses } from "./poses.js";
import { censusOf, curvesOf, cuspCurvesOf, loopOf, posesOf, tableOf, toleranceAt } from "./questions.js";
import { Save } from "./save.js";
import { lack, showCount } from "./slice.js";
import { SpaceView } from "./space_view.js";
import { faultOf, geometryText, hashOf, letterOf, stateOf } from "./state.js";
import { Steps } from "./steps.js";
import { CuspTable } from "./table.js";

const REST = 300; // ms without a change after which the page asks for the rest
const PANELS = { path: () => import("../tabs/path.js"), workspace: () => import("../tabs/workspace.js") };

class Explorer {
  state;
  shown = null; // the state that is drawn
  #curves = null; // its singular curves
  #slice = null; // the slice whose cusps are known, perhaps of a state that has passed
  #due = null; // the picture that the next frame draws: {state, slice, curves}
  #frame = null;
  #census = null; // the geometry whose census is drawn
  #poseTable = null; // the poses that are drawn, perhaps of a state that has passed
  #last = null; // the pose that is drawn
  #following = new Following(); // of the selected cusp
  #fate = ""; // what became of the cusp that was selected
  #merge = null; // the poses that merge at the joint vector
  #tolerance = toleranceAt(0);
  #timer = null;
  #rest = null; // the timer of a joint vector that is dragged
  #bound = null; // the timer of joint limits that are entered
  #route = null; // a path that is shown instead of the loop round the cusp
  #panels = new Map(); // panels whose modules are loaded when they are opened
  #near = null; // the special shape nearby
  #isBlocked = false; // whether fields are wrong

  #fields = new Fields({ onChange: (...change) => this.#change(...change) });
  asking = new Asking({ fields: this.#fields, isCurrent: (state) => this.#isCurrent(state), onRetry: () => this.#settle() });
  #mechanism = new Mechanism({
    onDrag: (geometry) => this.#change({ geometry }),
    onMove: (pose) => this.#moveTo(pose),
    onRest: () => this.#draw(),
  });
  strip = new CensusStrip({ onChange: (l1, by) => this.#change({ l1 }, false, by), onReach: () => this.#pictures.prepare() });
  #joint = new JointSpace({
    onSelect: (index) => this.#select(index),
    onVisit: (index) => this.#visit(index),
    onPick: (vector) => this.#pick(vector),
    onHold: (vector) => this.#hold(vector),
    onPose: (pose) => this.#moveTo({ ...pose, l1: toNumber(this.state.l1) }),
    onLimits: (limits) => this.#limit({ ...this.state.limits, ...limits }),
    onZoom: (factor) => this.#refine(factor),
  });
  #space = new SpaceView({
    onSelect: (index) => this.#select(index),
    onGo: (l1) => this.#change({ l1, at: null }),
    onEye: (eye) => {
      this.state = { ...this.state, eye };
      this.#tell(true);
    },
    ask: (name, question, told) => this.asking.ask(name, this.state, question, { isLate: true, ...told }),
  });
  #table = new CuspTable({ onSelect: (index) => this.#select(index) });
  #motion = new Motion({ onMove: (sample) => this.#move(sample) });
  #poses = new Poses({
    onPick: (vector) => this.#pick(vector),
    onChoose: (pose) => this.#choosePose({ pose }),
    onHome: () => this.#keep({ l1: this.state.l1, ...this.state.at }),
    onGo: ({ l1, ...at }) => this.#change({ l1, at }),
  });
  #exactness = new Exactness({ ask: (...question) => this.#ask(...question), onOpen: (geometry) => this.#open(geometry) });
  #improve = new Improve({
    run: (task) => this.asking.run("design", this.state, (follow) => task(this.state.geometry, follow)),
    onShow: (geometry) => this.#mechanism.drawCandidate(geometry),
    onOpen: (geometry) => this.#open(geometry),
  });
  #limits = new JointLimits({
    onChange: (limits) => this.#limit(limits),
    onDraw: (isDrawing) => {
      if (isDrawing) this.#view("joint");
      this.#joint.isDrawing = isDrawing;
    },
    onPath: (path) => this.#showRoute(path),
    ask: (...question) => this.#ask(...question),
  });
  #calls = new Calls();
  #save = new Save({
    space: () => {
      this.#view("space");
      return this.#space.image();
    },
  });
  #steps = new Steps({ onGo: (hash) => this.#go(hash) });
  #pictures = new Pictures(this);

  open() {
    bindPanel((id) => this.#openPanel(id));
    const fault = location.hash.length > 1 && !stateOf(location.hash) ? faultOf(location.hash) : "";
    this.state = stateOf(location.hash) ?? { ...firstExample(), view: "joint", mode: "move" };
    notice(fault);
    this.#show();
    this.#joint.drawLimits(this.state.limits);
    on("near-open", "click", () => this.#open(this.#near.spelling));
    this.#settle();
    this.#space.open(this.state.view === "space");
    for (const radio of document.querySelectorAll("input[name=view]")) on(radio, "change", () => this.#view(radio.value));
    for (const radio of document.querySelectorAll("input[name=mode]")) on(radio, "change", () => this.#take({ mode: radio.value }));
  }

  #go(hash) {
    const state = stateOf(hash);
    notice(state ? "" : faultOf(hash).replace("The first example is shown.", "The picture is as it was."));
    if (!state || hashOf(state) === hashOf(this.state)) return;
    this.#change(state, geometryText(state.geometry) !== geometryText(this.state.geometry));
    this.#view(state.view, false);
  }

  /** Takes a change of what a drag does. */
  #take(change) {
    this.state = { ...this.state, ...change };
    this.#mechanism.mode = this.state.mode;
    this.#tell();
  }

  /** Shows a geometry of a document. */
  #open(geometry) {
    this.#change({ geometry: isSix(geometry) ? geometry : pairOf(geometry), at: null }, true);
  }

  /** Takes a change, of L1 by steps of the slider: asks for the slice at once, for the rest at rest. */
  #change(change, isWhole = false, by = 0) {
    if (change.geometry) {
      this.asking.cancel("census", "design", "path", "workspace");
      this.#improve.clear();
      byId("near").hidden = true;
    }
    this.asking.cancel("loop", "margin", "cusp curves");
    this.#fate = "";
    if ("cusp" in change) this.#following.forget();
    this.#exactness.clear();
    this.#limits.clear();
    this.#clearLoop();
    this.state = { ...this.state, ...change };
    if (isWhole) this.#joint.fitNext();
    if ("limits" in change) this.#joint.drawLimits(change.limits);
    this.#merge = null;
    if (!this.state.at || "at" in change) this.#poseTable = null;
    else this.#follow();
    this.#later();
    clearTimeout(this.#timer);
    if (this.#isWrong()) return;
    this.#pictures.move(by);
    this.#timer = setTimeout(() => this.#settle(), REST);
  }

  /** Whether fields of the state are wrong, each of which says so; then nothing is asked, and what is shown is dimmed. */
  #isWrong() {
    const faults = Fields.faultsOf(this.state);
    if (faults.length > 0) this.#fields.refuse(faults);
    this.#block(faults.length > 0);
    return faults.length > 0;
  }

  #block(isWrong) {
    if (isWrong === this.#isBlocked) return;
    this.#isBlocked = isWrong;
    this.#save.block(isWrong);
    for (const id of ["slice", "census", "table", "poses"]) byId(id).classList.toggle("wrong", isWrong);
    if (isWrong) write("window", "");
  }

  /** Shows the state, and the picture that is due, in the next frame: once, however much changes until then. */
  #later() {
    this.#frame ??= requestAnimationFrame(() => {
      this.#frame = null;
      this.#show();
      if (this.state.at) this.#drawPoses();
      if (this.#due) this.#picture(this.#due);
      this.#due = null;
    });
  }

  #show() {
    const { geometry, l1, view, mode } = this.state;
    this.#fields.show(this.state);
    this.strip.show(l1);
    this.#improve.propose(l1);
    this.#poses.show(this.state.at);
    this.#tellPanels();
    byId(`view-${view}`).checked = true;
    this.#fillSpace();
    byId(`mode-${mode}`).checked = true;
    this.#mechanism.mode = mode;
    byId("slice").classList.toggle("stale", !this.isShown);
    if (this.#census !== geometryText(geometry)) byId("census").classList.add("stale");
    if (!this.#mechanism.isHeld && this.#mechanism.isOther(geometry)) this.#draw(); // else it has drawn itself
  }

  get isShown() {
    return this.shown !== null && this.#isCurrent(this.shown);
  }

  /** Asks for everything about the state in which the page has come to rest. */
  async #settle() {
    const state = this.state;
    this.#pictures.drop();
    this.asking.cancel("slice 0", "slice 1", "slice 2");
    this.#tell();
    byId("slice").classList.toggle("late", !this.isShown);
    if (this.#isWrong()) return;
    this.#table.link(tableOf(state));
    const [slice, curves] = await Promise.all([this.#askTable(state), this.#askCurves(state)]);
    if (!slice) return;
    if (curves || !this.#curves) this.take({ state, slice, curves }); // else the last picture stays
    else this.#draw();
    await this.#askPoses(); // first the picture, before a worker is busy for longer
    if (this.#census === geometryText(state.geometry)) await this.#askFate(state); // else first the census
    await this.#askLoop();
    if (this.#isCurrent(state)) await this.#askCensus(state);
    if (await this.#askFate(state)) await this.#askLoop();
  }

  /** Whether the page still asks what it asked in a state. */
  #isCurrent({ geometry, l1 }) {
    return l1 === this.state.l1 && geometryText(geometry) === geometryText(this.state.geometry);
  }

  async #askTable(state) {
    const table = await this.asking.ask("slice", state, tableOf(state));
    if (!table) return null;
    const [slice] = table.slices;
    this.#tellSlice(slice);
    this.#tellNear(table);
    this.#table.draw(slice, this.#selected);
    if (slice.error) this.#fields.refuse([{ field: "l1", message: slice.error.detail }]);
    say(byId("count").textContent);
    return slice;
  }

  /** Says that the geometry may be a rounded one of a special shape, of which the answer would be another one. */
  #tellNear(answer) {
    this.#near = nearOf(answer);
    byId("near").hidden = !this.#near;
    write("near-text", nearText(this.#near));
  }

  async #askCurves(state) {
    let reason = "";
    const curves = await this.asking.ask("curves", state, curvesOf(state, this.#tolerance), { onRefusal: (why) => (reason = why) });
    if (curves) this.#poses.offer(curves, this.state.at);
    if (curves || reason) lack(state.l1, reason, !this.#curves);
    return curves;
  }

  /** Asks for a panel: what `questionOf(state)` gives. */
  #ask(name, questionOf, told) {
    this.#tell();
    return this.asking.ask(name, this.state, questionOf(this.state), told);
  }

  async #refine(factor) {
    const [state, tolerance] = [this.state, toleranceAt(factor)];
    if (tolerance === this.#tolerance) return;
    this.#tolerance = tolerance;
    const curves = await this.#askCurves(state);
    if (curves) this.take({ state, slice: this.#slice, curves });
  }

  take(picture) {
    this.#due = picture;
    this.#later();
  }

  /**
   * Asks which cusp of the slice is the one that was selected in another, and goes on with the nearest one if it has ended.
   * Tells whether it is another one than was thought.
   */
  async #askFate(state) {
    const geometry = geometryText(state.geometry);
    const since = this.#following.since({ geometry, l1: state.l1 });
    const curves = since && (await this.asking.ask("cusp curves", state, cuspCurvesOf(state, since.l1), { onRefusal() {} }));
    if (!this.#isCurrent(state) || since !== this.#following.since({ geometry, l1: state.l1 })) return false;
    const fate = curves && fateOf(curves, since, state.l1);
    if (fate?.end) this.#fate = `The selected cusp ended at L1 = ${shortened(fate.end.l1)} (${fate.end.kind}). `;
    const isOther = fate?.cusp !== undefined && fate.cusp !== this.#selected;
    if (isOther) this.#mark(fate.cusp);
    if (since) this.#visit(this.#selected);
    if (fate?.end) say(byId("visited").textContent);
    this.#following.know({ geometry, l1: state.l1, cusp: this.#selected });
    this.#tell(true);
    return isOther;
  }

  #tellSlice(slice) {
    this.#slice = slice;
    const cusp = this.#following.numberIn(slice);
    if (cusp === null) this.#following.start(slice.l1, this.#cusp);
    else this.state = { ...this.state, cusp };
    this.asking.clear();
    this.#block(false);
    showCount(slice);
    this.#limits.show(this.state.limits, slice.cusps);
  }

  #picture({ state, slice, curves }) {
    [this.shown, this.#curves] = [state, curves];
    if (slice !== this.#slice) {
      this.#tellSlice(slice);
      this.#table.draw(slice, this.#selected);
    }
    byId("slice").classList.toggle("stale", !this.isShown);
    byId("slice").classList.remove("late");
    if (curves) lack(state.l1, "");
    if (!this.#space.isOpen) this.#joint.draw(slice, curves, this.state.view, this.#selected);
    this.#fillSpace();
    showLegend(legendOf(curves, this.state.view));
    this.#visit(this.#selected);
    if (!this.state.at) this.#drawVector();
    if (!this.#mechanism.isHeld) this.#draw();
    document.body.dataset.pictures = Number(document.body.dataset.pictures ?? 0) + 1;
  }

  async #askLoop() {
    const state = this.state;
    if (this.#route) return false;
    this.#clearLoop();
    if (!this.#cusp) return false;
    if (state.limits && !isWithin(this.#cusp, state.limits)) {
      this.#motion.show(null, `Cusp ${letterOf(this.#selected)} is outside the joint limits, and so is every loop round it.`);
      return false;
    }
    const told = { onRefusal: (reason) => this.#motion.show(null, reason) };
    const path = await this.asking.ask("loop", state, loopOf(state, letterOf(this.#selected)), told);
    if (!path || this.#route || state.limits !== this.state.limits) return false;
    this.#showPath(path);
    return true;
  }

  #showPath(path) {
    this.#motion.show(path);
    this.#joint.drawLoop(this.#motion.samples, Boolean(this.#route));
    this.#fillSpace();
    this.#draw();
  }

  /** Shows and plays a path of another question instead of the loop round the cusp, over the slice in which it begins. */
  #showRoute(path) {
    const [{ l1 }] = path.samples;
    if (toNumber(l1) !== toNumber(this.state.l1)) this.#change({ l1: path.l1 ?? path.from.l1 ?? l1 });
    this.asking.cancel("loop");
    this.#route = path;
    this.#showPath(path);
    this.#move(this.#motion.samples[0]);
    this.#motion.playUnlessCalm();
  }

  #pick(vector) {
    this.#hold({ ...vector, merge: null });
    clearTimeout(this.#rest);
    this.#tell();
    this.#askPoses();
  }

  /** Takes a joint vector while it is dragged: its poses at once, those of the service at rest. */
  #hold({ l2, l3, merge }) {
    this.#motion.pause();
    this.state = { ...this.state, at: { l2, l3, pose: 0 } };
    this.#merge = merge;
    this.#follow();
    this.#later();
    write("visited", this.#heldText());
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => {
      this.#tell();
      this.#askPoses();
    }, REST);
  }

  /** Takes a pose `{l1, alpha_deg, theta1_deg}`, and the joint vector that it has. */
  #moveTo(pose) {
    const lengths = measured(this.state.geometry);
    if (!lengths) return;
    this.#last = pose;
    this.#hold(vectorNear(lengths, pose));
  }

  /** Takes a pose of any L1. */
  #moveOff(pose) {
    const lengths = measured(this.state.geometry);
    const l1 = decimal(pose.l1, placesOf(lengths));
    const [, l2, l3] = vectorOf(lengths, { ...pose, l1: toNumber(l1) }).map((length) => decimal(length, placesOf(lengths)));
    this.#last = pose;
    this.#change({ l1, at: { l2, l3, pose: 0 } });
    this.#follow();
  }

  /** Takes the poses of the state in doubles, and of them the nearest to the one that was drawn. */
  #follow() {
    const { geometry, l1, at } = this.state;
    const poses = posesAt(geometry, { l1, l2: at.l2, l3: at.l3, merge: this.#merge });
    this.#poseTable = { l1, l2: at.l2, l3: at.l3, count: poses.length, poses, isDraft: true };
    this.state = { ...this.state, at: { ...at, pose: Math.max(nearestIn(poses, this.#last), 0) } };
    this.#poses.draw(this.#poseTable, this.state.at.pose);
    this.#poses.wait();
  }

  #heldText() {
    const { l2, l3, count } = this.#poseTable;
    const merged = this.#merge && (this.#merge.count === 3 ? `; at cusp ${letterOf(this.#merge.cusp)} three have merged` : "; on the singular curve two have merged");
    return `L2 = ${shortened(toNumber(l2))}, L3 = ${shortened(toNumber(l3))}: ${count === 0 ? "no pose" : `${count} pose${count === 1 ? "" : "s"}`}${merged ?? ""}`;
  }

  #choosePose(pose) {
    this.#motion.pause();
    this.#pose({ ...this.state.at, ...pose });
  }

  /** Shows a pose of a joint vector, or for null leaves them for a cusp or its loop. */
  #pose(at) {
    this.state = { ...this.state, at };
    if (!at) {
      this.#poseTable = this.#merge = null;
      this.#visit(this.#selected);
    }
    this.#poses.show(at);
    this.#tellPanels();
    this.#tell();
    this.#drawPoses();
  }

  #keep(home) {
    this.state = { ...this.state, home };
    this.#tellPanels();
    this.#tell();
  }

  /** Loads the module of a panel that has one, when it is opened for the first time. */
  async #openPanel(id) {
    if (!(id in PANELS)) return;
    if (this.#panels.get(id)) this.#tellPanels();
    if (this.#panels.has(id)) return;
    this.#panels.set(id, null);
    const { Panel } = await PANELS[id]();
    const told = {
      ask: (...question) => this.#ask(...question),
      onPath: (path) => this.#showRoute(path),
      onLimits: (limits) => this.#limit(limits),
      onPose: (pose) => this.#moveOff(pose),
    };
    this.#panels.set(id, new Panel(byId(id), told));
    this.#tellPanels();
  }

  /** Tells the panels about the state: the poses that are listed, and the cusp that is selected. */
  #tellPanels() {
    this.#poses.keep(this.state);
    const shown = { ...this.state, poses: this.#poseTable?.poses ?? [], isDraft: this.#poseTable?.isDraft ?? false, cusp: this.#cusp ? letterOf(this.#selected) : null, here: this.#last };
    for (const panel of this.#panels.values()) panel?.show(shown);
  }

  async #askPoses() {
    const state = this.state;
    if (!state.at) return;
    const table = await this.asking.ask("poses", state, posesOf(state));
    const now = this.state.at;
    if (!table || now?.l2 !== state.at.l2 || now.l3 !== state.at.l3) return;
    const isFollowed = this.#poseTable?.isDraft;
    const pose = isFollowed ? Math.max(nearestIn(table.poses, this.#last), 0) : Math.min(now.pose, Math.max(table.count - 1, 0));
    this.state = { ...this.state, at: { ...now, pose } };
    this.#fields.clear();
    this.#poseTable = table;
    this.#poses.draw(table, pose);
    this.#tellPanels();
    say(byId("pose-count").textContent);
    this.#drawPoses();
  }

  #drawPoses() {
    this.#drawVector();
    this.#fillSpace();
    this.#draw();
  }

  /** Marks the joint vector of the pose that is drawn: the one that was chosen, or that of the cusp. */
  #drawVector() {
    const { at } = this.state;
    if (at) this.#joint.drawPoses(at, this.#poseTable?.poses ?? []);
    else this.#joint.drawPoses(this.#cusp ?? null, []);
  }

  /** What is outlined: the other poses of the joint vector, or both ends of the loop. */
  get #others() {
    const { at, l1 } = this.state;
    const poses = (this.#poseTable?.poses ?? []).map((pose) => ({ ...pose, l1 }));
    const ends = [this.#motion.samples.at(0), this.#motion.samples.at(-1)].filter(Boolean);
    return at ? othersOf(poses, at.pose) : ends.map((end, k) => ({ ...end, name: this.#motion.ends[k] }));
  }

  #clearLoop() {
    this.#route = null;
    const isDrawn = this.#motion.samples.length > 0;
    this.#motion.show(null);
    if (!isDrawn) return;
    this.#joint.drawLoop([]);
    this.#fillSpace();
    if (!this.state.at) this.#mechanism.clearOthers();
  }

  #move(sample) {
    if (this.state.at) this.#pose(null);
    const { geometry } = this.state;
    const poses = posesAt(geometry, sample);
    const pose = nearestIn(poses, sample);
    this.#mechanism.draw(geometry, sample, othersOf(poses, pose));
    this.#joint.drawPoses({ ...sample, pose }, poses);
    this.#last = sample;
    this.#fillSpace(sample);
  }

  async #askCensus(state) {
    const text = geometryText(state.geometry);
    if (this.#census === text) return;
    const census = await this.asking.ask("census", state, censusOf(state), { wait: 0 });
    if (!census) return;
    this.#census = text;
    byId("census").classList.remove("stale");
    this.strip.draw(census);
  }

  #limit(limits) {
    this.state = { ...this.state, limits };
    this.#limits.clear();
    this.#tellPanels();
    this.#limits.show(limits, this.#slice?.cusps);
    this.#joint.drawLimits(limits);
    this.#fillSpace();
    if (limits) this.#limits.draws(false);
    this.#tell();
    this.asking.cancel("loop");
    this.#clearLoop();
    clearTimeout(this.#bound);
    this.#bound = setTimeout(() => this.#askLoop(), REST);
  }

  async #select(index) {
    if (this.state.at) this.#pose(null);
    this.#fate = "";
    this.#route = null;
    this.#mark(index);
    this.#following.know({ geometry: geometryText(this.state.geometry), l1: this.#slice.l1, cusp: index });
    this.#tell();
    if (await this.#askLoop()) this.#motion.playUnlessCalm();
  }

  #mark(index) {
    this.state = { ...this.state, cusp: index };
    this.#following.start(this.#slice.l1, this.#cusp);
    if (this.isShown) this.#joint.select(index);
    this.#fillSpace();
    this.#table.select(index);
    this.#visit(index);
    if (!this.state.at) this.#drawPoses();
  }

  /** The number of the selected cusp: the last if there are fewer. */
  get #selected() {
    return Math.min(this.state.cusp, Math.max((this.#slice?.cusps ?? []).length - 1, 0));
  }

  get #cusp() {
    return this.#slice?.cusps?.[this.#selected];
  }

  #visit(index) {
    const cusp = this.#slice?.cusps?.[index];
    const fate = index === this.#selected ? this.#fate : "";
    write("visited", fate + (cusp ? `${fate && "Selected now: "}${spoken(cusp, index)}` : ""));
  }

  #view(view, isStep = true) {
    this.state = { ...this.state, view };
    byId(`view-${view}`).checked = true;
    if (isStep) this.#tell();
    this.#space.open(view === "space");
    if (view !== "space" && this.#slice) this.#joint.draw(this.#slice, this.#curves, view, this.#selected);
    this.#fillSpace();
    showLegend(legendOf(this.#curves, view));
  }

  /** Tells the picture in three dimensions what there is to see. */
  #fillSpace(here = null) {
    const { geometry, l1, limits, at, eye } = this.state;
    const isShown = Boolean(this.isShown && this.#curves);
    this.#space.set({ geometry, l1, limits, at, eye, here, isShown, slice: this.#slice, curves: this.#curves, selected: this.#selected, path: this.#motion.samples });
  }

  #draw() {
    const { geometry, l1, at } = this.state;
    const isNone = at && this.#poseTable?.count === 0;
    const shown = (at && this.#poseTable?.poses[at.pose]) ?? (isNone ? this.#last : this.#cusp);
    byId("mechanism").classList.toggle("absent", Boolean(isNone));
    this.#last = { alpha_deg: 0, theta1_deg: 60, ...shown, l1 };
    this.#mechanism.draw(geometry, this.#last, this.#others);
  }

  #tell(isAmended = false) {
    this.#steps.take(hashOf(this.state), isAmended);
    this.#save.show(this.state);
    this.#calls.show({ ...this.state, tolerance: this.#exactness.tolerance, wish: this.#improve.members });
  }
}

/** All poses but one, with their numbers. */
const othersOf = (poses, chosen) => poses.map((pose, k) => ({ ...pose, name: k + 1 })).filter((_, k) => k !== chosen);

new Explorer().open();
