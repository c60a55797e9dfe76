/** The table of the cusps, which selects them as the picture does, and its copies. */

import { address, call, key } from "./api.js";
import { shortened } from "./decimals.js";
import { byId, copy, make, on, say } from "./dom.js";
import { letterOf } from "./state.js";

const COLUMNS = ["l2", "l3", "alpha_deg", "theta1_deg"];

export class CuspTable {
  #slice = null;
  #onSelect;

  constructor({ onSelect }) {
    this.#onSelect = onSelect;
    on("copy-table", "click", () => copy(this.#text(), "The table is copied."));
    on("latex", "click", () => copy(this.#latex(), "The LaTeX table is copied."));
    on("csv", "click", fetchWithKey);
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

  link({ geometry, l1 }, digits) {
    byId("csv").href = address(`v1/cusp-tables?${new URLSearchParams({ ...geometry, l1, digits, format: "csv" })}`);
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

/** A link sends no key, so with one the page fetches the file itself. */
export async function fetchWithKey(event) {
  if (!key.get()) return;
  event.preventDefault();
  const link = event.currentTarget;
  try {
    const url = URL.createObjectURL(await (await call(link.href)).blob());
    make("a", { href: url, download: link.download }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  } catch (error) {
    say(error.message);
  }
}
