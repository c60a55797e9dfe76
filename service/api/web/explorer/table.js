/** The table of the cusps, which selects them as the picture does, and its copies. */

import { address, call, key } from "./api.js";
import { shortened } from "./decimals.js";
import { geometryOf, geometryText, letterOf } from "./state.js";

const COLUMNS = ["l2", "l3", "alpha_deg", "theta1_deg"];
const byId = (id) => document.getElementById(id);

export class CuspTable {
  #slice = null;
  #onSelect;

  constructor({ onSelect, say }) {
    this.#onSelect = onSelect;
    byId("copy-table").addEventListener("click", () => copy(this.#text(), "The table is copied.", say));
    byId("copy-cusp").addEventListener("click", () => copy(this.#cuspText(), "The cusp is copied.", say));
    byId("latex").addEventListener("click", () => copy(this.#latex(), "The LaTeX table is copied.", say));
    for (const id of ["csv", "json"]) byId(id).addEventListener("click", (event) => fetchWithKey(event, say));
  }

  #selected = 0;

  draw(slice, selected) {
    this.#slice = slice;
    const rows = (slice?.cusps ?? []).map((cusp, k) => this.#row(cusp, k));
    const others = (slice?.degenerate_points ?? []).map(degenerateRow);
    byId("cusp-rows").replaceChildren(...rows, ...others);
    byId("no-cusps").hidden = rows.length + others.length > 0 || !slice;
    this.select(selected);
  }

  select(index) {
    this.#selected = index;
    for (const button of byId("cusp-rows").querySelectorAll("button")) {
      const isSelected = Number(button.dataset.cusp) === index;
      button.setAttribute("aria-pressed", String(isSelected));
      button.closest("tr").classList.toggle("selected", isSelected);
    }
    byId("copy-cusp").disabled = !this.#slice?.cusps?.[index];
  }

  /** Links the table's CSV and JSON: addresses of the public API. */
  link(geometry, l1, digits) {
    for (const [id, format] of [["csv", "csv"], ["json", "json"]]) {
      byId(id).href = tableAddress(geometry, l1, digits, format);
    }
  }

  #row(cusp, index) {
    const row = document.createElement("tr");
    const head = document.createElement("th");
    head.scope = "row";
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = letterOf(index);
    button.dataset.cusp = index;
    button.setAttribute("aria-label", `Select cusp ${letterOf(index)}`);
    row.addEventListener("click", () => this.#onSelect(index));
    head.append(button);
    row.append(head);
    for (const name of COLUMNS) row.insertCell().textContent = shortened(cusp[name], 7);
    return row;
  }

  #text() {
    const rows = (this.#slice?.cusps ?? []).map((cusp, k) => [letterOf(k), ...COLUMNS.map((name) => cusp[name])]);
    return [["cusp", ...COLUMNS], ...rows].map((row) => row.join("\t")).join("\n");
  }

  /** A table of the package booktabs, with ten digits. */
  #latex() {
    const rows = (this.#slice?.cusps ?? []).map((cusp, k) => [letterOf(k), ...COLUMNS.map((name) => `$${shortened(cusp[name], 10).replace("−", "-")}$`)]);
    const head = ["", "$L_2$", "$L_3$", "$\\alpha$ [deg]", "$\\theta_1$ [deg]"];
    const lines = [head, ...rows].map((row) => `${row.join(" & ")} \\\\`);
    return ["\\begin{tabular}{lrrrr}", "\\toprule", lines[0], "\\midrule", ...lines.slice(1), "\\bottomrule", "\\end{tabular}"].join("\n");
  }

  #cuspText() {
    const cusp = this.#slice.cusps[this.#selected];
    return COLUMNS.map((name) => `${name}\t${cusp[name]}`).join("\n");
  }
}

function tableAddress(geometry, l1, digits, format) {
  const query = new URLSearchParams({ ...geometryOf(geometryText(geometry)), l1, digits, format });
  return address(`v1/cusp-tables?${query}`);
}

export async function copy(text, done, say) {
  try {
    await navigator.clipboard.writeText(text);
    say(done);
  } catch {
    say("This browser does not let the page copy.");
  }
}

function degenerateRow(point) {
  const row = document.createElement("tr");
  row.className = "degenerate";
  const head = document.createElement("th");
  head.scope = "row";
  head.textContent = point.kind;
  row.append(head);
  if (point.equation === undefined) {
    for (const name of COLUMNS) row.insertCell().textContent = point[name] === undefined ? "" : shortened(point[name], 7);
  } else {
    const cell = row.insertCell();
    cell.colSpan = COLUMNS.length;
    cell.textContent = point.equation;
  }
  return row;
}

/** A link sends no key, so with one the page fetches the file itself. */
export async function fetchWithKey(event, say) {
  if (!key.get()) return;
  event.preventDefault();
  const link = event.currentTarget;
  try {
    const url = URL.createObjectURL(await (await call(link.href)).blob());
    const file = Object.assign(document.createElement("a"), { href: url, download: link.download });
    file.click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  } catch (error) {
    say(error.message);
  }
}
