/** The table of the cusps, which selects them as the picture does, and its copies. */

import { save } from "./api.js";
import { shortened } from "./decimals.js";
import { byId, copy, make, on } from "./dom.js";
import { letterOf } from "./state.js";

const COLUMNS = ["l2", "l3", "alpha_deg", "theta1_deg"];

export class CuspTable {
  #slice = null;
  #asked = null;
  #onSelect;

  constructor({ onSelect }) {
    this.#onSelect = onSelect;
    on("copy-table", "click", () => copy(this.#text(), "The table is copied."));
    on("latex", "click", () => copy(this.#latex(), "The LaTeX table is copied."));
    on("csv", "click", () => save(this.#asked, "text/csv", "cusps.csv"));
  }

  draw(slice, selected) {
    this.#slice = slice;
    const rows = (slice?.cusps ?? []).map((cusp, k) => this.#row(cusp, k));
    const others = (slice?.degenerate_points ?? []).map(degenerateRow);
    byId("cusp-rows").replaceChildren(...rows, ...others);
    byId("no-cusps").hidden = rows.length + others.length > 0 || !slice;
    this.select(selected);
  }

  select(index) {
    for (const button of byId("cusp-rows").querySelectorAll("button")) {
      const isSelected = Number(button.dataset.cusp) === index;
      button.ariaPressed = isSelected;
      button.closest("tr").classList.toggle("selected", isSelected);
    }
  }

  /** Takes the question that the file with the table answers. */
  link(question) {
    this.#asked = question;
  }

  #row(cusp, index) {
    const letter = letterOf(index);
    const button = make("button", { textContent: letter, ariaLabel: `Select cusp ${letter}` });
    button.dataset.cusp = index;
    const row = make("tr", {}, make("th", { scope: "row" }, button));
    on(row, "click", () => this.#onSelect(index));
    return filled(row, cusp);
  }

  #text() {
    return [["cusp", ...COLUMNS], ...this.#cells()].map((row) => row.join("\t")).join("\n");
  }

  #cells(write = (text) => text) {
    return (this.#slice?.cusps ?? []).map((cusp, k) => [letterOf(k), ...COLUMNS.map((name) => write(cusp[name]))]);
  }

  /** A table of the package booktabs, with ten digits. */
  #latex() {
    const head = ["", "$L_2$", "$L_3$", "$\\alpha$ [deg]", "$\\theta_1$ [deg]"];
    const lines = [head, ...this.#cells((text) => `$${shortened(text, 10).replace("−", "-")}$`)].map((row) => `${row.join(" & ")} \\\\`);
    return ["\\begin{tabular}{lrrrr}", "\\toprule", lines[0], "\\midrule", ...lines.slice(1), "\\bottomrule", "\\end{tabular}"].join("\n");
  }
}

function degenerateRow(point) {
  const row = make("tr", { className: "degenerate" }, make("th", { scope: "row", textContent: point.kind }));
  if (point.equation === undefined) return filled(row, point);
  row.append(make("td", { colSpan: COLUMNS.length, textContent: point.equation }));
  return row;
}

function filled(row, point) {
  row.append(...COLUMNS.map((name) => make("td", { textContent: point[name] === undefined ? "" : shortened(point[name], 7) })));
  return row;
}
