/** "Path": from one pose to another without a singularity, by limits of motion; or why there is no such path. */

import { keep } from "../explorer/api.js";
import { pointed, shortened, toNumber } from "../explorer/decimals.js";
import { byId, on, write } from "../explorer/dom.js";
import { described } from "../explorer/motion.js";
import { poseText } from "../explorer/poses.js";
import { SAMPLES, WHILE_MOVING, freeLimits, limitsIn } from "../explorer/questions.js";
import { geometryText } from "../explorer/state.js";

const LEGS = ["l1", "l2", "l3"];

const MARKUP = `
<p class="hint">From one <button class="term">pose</button> to another without a
<button class="term" data-term="singular pose">singularity</button>, within the joint limits; or why there is no such path.</p>
<p id="path-from"></p>
<div class="buttons"><button id="path-pin" disabled>Begin at the shown pose</button></div>
<form id="path-form" class="fields" aria-label="Path">
<label class="wide">To<select id="path-to"></select></label>
<label>Speed<input id="path-speed" inputmode="decimal" placeholder="no limit"></label>
<label>Acceleration<input id="path-acceleration" inputmode="decimal" placeholder="no limit"></label>
<label>Jerk<input id="path-jerk" inputmode="decimal" placeholder="no limit"></label>
<label>Samples by<select id="path-sampling"><option value="number">number</option><option value="step">steps of time</option>
<option value="chord">chords within</option></select></label>
<label><span id="path-rows-label">Number</span><input id="path-rows" inputmode="decimal" value="${SAMPLES}"></label>
<label>Clearance [°]<input id="path-clearance" placeholder="best, 0.5" autocomplete="off"></label>
</form>
<div class="buttons"><button type="submit" id="path-compute" form="path-form" disabled>Compute</button>
<button id="path-csv" disabled>CSV of the samples</button><button id="path-json" disabled>JSON</button></div>
<p id="path-verdict" class="count" aria-live="polite"></p>
<p id="path-more" class="hint"></p>
<button id="path-range" hidden></button>`;

const OBSTACLES = {
  "opposite-signs": () => "J has different signs at the two poses, so that every path meets a singularity, whatever L1 does. This is proved.",
  "other-aspect": ({ between }) => `the two poses are in different aspects of ${between ? "the range of L1" : "the slice"}: every path there meets a singularity. This is proved.`,
  "too-narrow": ({ clearance }) => `none keeps so far from singular poses${clearance?.bound ? `, and none has more than ${shortened(clearance.bound, 4)}°` : ""}. This is proved.`,
  "ill-conditioned": () => "a pose at an end has a greater condition number than is allowed.",
  "outside-limits": () => "a pose at an end is outside the joint limits.",
  "separated-by-limits": () => "the joint limits separate the poses. This is proved.",
  "singular-pose": () => "a pose at an end is singular.",
};
const ROWS = { number: ["Number", String(SAMPLES)], step: ["Step", "0.01"], chord: ["Deviation", "0.01"] };

export class Panel {
  #told;
  #state = null;
  #from = null; // the pose at which the path begins, {l1, l2, l3, pose, poses}, if it was chosen
  #of = null; // its geometry
  #ends = {}; // where a path may lead, by the values of the list
  #path = null;

  /** `ask` asks about the state, `onPath(path)` is told which path is to be seen, `onLimits(limits)` which limits are to be kept. */
  constructor(section, told) {
    this.#told = told;
    section.innerHTML = MARKUP;
    on("path-form", "submit", (event) => {
      event.preventDefault();
      this.#compute();
    });
    on("path-pin", "click", () => {
      this.#from = this.#shown;
      this.#offer();
    });
    on("path-sampling", "change", () => {
      const [label, usual] = ROWS[byId("path-sampling").value];
      write("path-rows-label", label);
      byId("path-rows").value = usual;
    });
    on("path-csv", "click", () => keep(new Blob([csvOf(this.#path)], { type: "text/csv" }), "path.csv"));
    on("path-json", "click", () => keep(new Blob([JSON.stringify(this.#path, null, 1)], { type: "application/json" }), "path.json"));
  }

  show(state) {
    this.#state = state;
    if (this.#of !== geometryText(state.geometry)) {
      [this.#of, this.#from] = [geometryText(state.geometry), null];
      this.#take(null);
      this.#say("");
    }
    this.#offer();
  }

  /** The pose that is shown, with all of its lengths; null if it is one of a cusp or a loop. */
  get #shown() {
    const { l1, at, poses } = this.#state;
    return at && poses.length > 0 ? { l1, ...at, poses } : null;
  }

  #offer() {
    const { home, cusp, isDraft } = this.#state;
    const shown = this.#shown;
    const from = this.#from ?? shown;
    const to = [
      ...(from?.poses ?? []).map((_, pose) => ({ ...from, pose })).filter(({ pose }) => pose !== from.pose)
        .map((end) => [`p${end.pose}`, `pose ${end.pose + 1} of the same lengths`, end]),
      ...(shown && from && !areSame(shown, from) ? [["shown", `the shown one, ${poseText(shown)}`, shown]] : []),
      ...(home && from && !(areSame(home, from) && home.pose === from.pose) ? [["home", `the home pose, ${poseText(home)}`, home]] : []),
      ...(cusp ? [["loop", `round cusp ${cusp}, to another pose of the same lengths`, null]] : []),
    ];
    this.#ends = Object.fromEntries(to.map(([value, , end]) => [value, end]));
    const text = JSON.stringify(to.map(([value, words]) => [value, words]));
    const select = byId("path-to");
    if (select.dataset.shown !== text) {
      const chosen = select.value;
      select.replaceChildren(...to.map(([value, words]) => new Option(words, value)));
      if (chosen in this.#ends) select.value = chosen;
      select.dataset.shown = text;
    }
    write("path-from", from ? `From ${poseText(from)}.` : "Show a pose to begin at: click into the joint space, or use the tab Poses.");
    byId("path-pin").disabled = !shown || isDraft;
    byId("path-compute").disabled = to.length === 0 || isDraft;
  }

  #question({ geometry, l1, cusp, limits }) {
    const text = (name) => pointed(byId(`path-${name}`).value);
    const end = this.#ends[byId("path-to").value];
    const posed = ({ pose, ...joints }) => ({ ...Object.fromEntries(LEGS.map((leg) => [leg, joints[leg]])), pose: pose + 1 });
    const ends = end ? { from: posed(this.#from), to: posed(end) } : { l1, cusp };
    const { min, max } = limits?.l1 ?? {};
    const given = ["speed", "acceleration", "jerk"].map((name) => [name, text(name)]).filter(([, value]) => value);
    return ["v1/paths", {
      geometry, ...ends,
      ...(end && min && max ? { between: { from: min, to: max } } : {}),
      ...limitsIn(freeLimits(limits)),
      ...(text("clearance") ? { clearance: text("clearance") } : {}),
      ...(given.length > 0 ? { motion: Object.fromEntries(given) } : {}),
      sampling: { [byId("path-sampling").value]: byId("path-sampling").value === "number" ? Number(text("rows")) : text("rows") },
      digits: WHILE_MOVING,
    }];
  }

  async #compute() {
    if (byId("path-compute").disabled) return;
    this.#from ??= this.#shown; // which playing will replace
    this.#take(null);
    this.#say("Computing …");
    const onRefusal = (reason) => this.#say(reason.replaceAll(/(motion|sampling)\./g, ""));
    const path = await this.#told.ask("path", (state) => this.#question(state), { onRefusal, hasFields: true });
    if (path) this.#tell(path);
    else if (byId("path-verdict").textContent === "Computing …") this.#say("");
  }

  #tell(path) {
    const { obstacle, connecting_range: range, reason } = path;
    if (!path.connected) {
      const why = OBSTACLES[obstacle]?.(path) ?? reason ?? "whether there is one is undecided.";
      this.#say(path.connected === null ? "Undecided: neither a path nor a reason against one was found." : `No path: ${why}`);
      if (range) this.#offerRange(range);
      return;
    }
    this.#take(path);
    const { samples, duration, deviation, motion } = path;
    const off = LEGS.map((leg) => toNumber(deviation?.[leg] ?? "0"));
    const stops = motion?.stops.length ? `; the legs rest ${motion.stops.length === 1 ? "once" : `${motion.stops.length} times`} on the way` : "";
    const chords = deviation ? `, between which legs that move linearly are off by at most ${shortened(Math.max(...off), 3)}` : "";
    this.#say(described(path), `${samples.length} samples in a time of ${shortened(duration, 5)}${chords}${stops}. Play shows it.`);
    this.#told.onPath(path);
  }

  #offerRange({ from, to }) {
    const button = byId("path-range");
    button.hidden = false;
    button.textContent = `Let L1 vary from ${shortened(from, 5)} to ${shortened(to, 5)}, where there is one`;
    button.onclick = () => {
      this.#told.onLimits({ ...this.#state.limits, l1: { min: from, max: to } });
      this.#compute();
    };
  }

  #take(path) {
    this.#path = path;
    for (const id of ["path-csv", "path-json"]) byId(id).disabled = !path;
  }

  #say(text, more = "") {
    write("path-verdict", text);
    write("path-more", more);
    byId("path-range").hidden = true;
  }
}

const areSame = (one, other) => LEGS.every((leg) => one[leg] === other[leg]);

/** The samples as CSV, with the mean speeds of the legs from each to the next. */
function csvOf({ samples }) {
  const columns = Object.keys(samples[0]).filter((name) => name !== "place");
  const speeds = (k) => LEGS.map((leg) => {
    const [now, next] = [samples[k], samples[k + 1]];
    return next ? Number(((next[leg] - now[leg]) / (toNumber(next.time) - toNumber(now.time))).toPrecision(9)) : "";
  });
  const rows = samples.map((sample, k) => [...columns.map((name) => sample[name]), ...speeds(k)]);
  return [[...columns, ...LEGS.map((leg) => `mean_speed_${leg}`)], ...rows].map((row) => `${row.join(",")}\r\n`).join("");
}
