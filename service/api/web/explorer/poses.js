/** The poses of a joint vector: a list from which one is drawn, and the fields with its lengths. */

import { pointed, shortened, toNumber } from "./decimals.js";
import { byId, make, on, write } from "./dom.js";
import { fill } from "./form.js";

const FIELDS = ["l2", "l3"];
const TIMES = { 2: ", double", 3: ", triple" };

export class Poses {
  #regions = [];
  #onChoose;
  #home = null;

  /**
   * `onPick({l2, l3})` is told which joint vector is meant, `onChoose(index)` which of its poses, `onHome()` that the shown
   * one is the home pose, `onGo(home)` that it is to be shown again.
   */
  constructor({ onPick, onChoose, onHome, onGo }) {
    this.#onChoose = onChoose;
    on("set-home", "click", onHome);
    on("go-home", "click", () => onGo(this.#home));
    for (const name of FIELDS) {
      on(name, "input", () => {
        const [l2, l3] = FIELDS.map((field) => pointed(byId(field).value));
        byId("region").value = "";
        if (l2 && l3) onPick({ l2, l3 });
      });
    }
    on("region", "change", () => {
      const region = this.#regions[byId("region").value];
      if (region) onPick(region.point);
    });
  }

  show(at) {
    for (const name of FIELDS) fill(name, at?.[name] ?? "");
    const known = this.#regions.findIndex(({ point }) => at && FIELDS.every((name) => point[name] === at[name]));
    byId("region").value = known < 0 ? "" : String(known);
    if (!at) this.draw(null);
  }

  /** Takes the home pose of a state. */
  keep({ home, at }) {
    this.#home = home;
    byId("go-home").disabled = !home;
    byId("set-home").disabled = !at;
    write("home-text", home ? `Home, kept in the link: ${poseText(home)}.` : "");
  }

  offer(curves, at) {
    this.#regions = (curves?.regions ?? []).filter(({ bounded }) => bounded);
    const options = this.#regions.map(({ poses, point }, k) => {
      const place = FIELDS.map((name) => shortened(toNumber(point[name]), 4)).join(", ");
      return new Option(`${poses} poses: ${place}`, k);
    });
    byId("region").replaceChildren(byId("region").options[0], ...options);
    this.show(at);
  }

  draw(table, chosen = 0) {
    byId("poses").classList.remove("stale");
    write("pose-count", table ? spoken(table) : "");
    byId("pose-list").hidden = !table?.poses.length;
    const rows = (table?.poses ?? []).map((pose, k) => this.#row(pose, k, k === chosen));
    byId("pose-list").replaceChildren(byId("pose-list").firstElementChild, ...rows);
  }

  wait() {
    byId("poses").classList.add("stale");
  }

  #row(pose, index, isChosen) {
    const radio = make("input", { type: "radio", name: "pose", value: index, checked: isChosen });
    on(radio, "change", () => this.#onChoose(index));
    return make("label", {}, radio, ` ${index + 1}: α = ${shortened(pose.alpha_deg, 5)}°, θ1 = ${shortened(pose.theta1_deg, 5)}°${placed(pose)}${TIMES[pose.multiplicity] ?? ""}`);
  }
}

/** The place of the platform in the frame of the points by which the manipulator was given. */
export function placed({ x, y, phi_deg: phi }) {
  return phi === undefined ? "" : `; x = ${shortened(x, 5)}, y = ${shortened(y, 5)}, φ = ${shortened(phi, 5)}°`;
}

/** A pose of a joint vector in words. */
export const poseText = ({ l1, l2, l3, pose }) => `pose ${pose + 1} of L1 = ${l1}, L2 = ${l2}, L3 = ${l3}`;

function spoken({ l1, l2, l3, count }) {
  return `L1 = ${l1}, L2 = ${l2}, L3 = ${l3}: ${count === 0 ? "no pose" : count === 1 ? "1 pose" : `${count} poses`}`;
}
