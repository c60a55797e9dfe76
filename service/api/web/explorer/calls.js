/** "Call this": what is shown, as a call of another program. */

import { address, key } from "./api.js";
import { LENGTHS } from "./geometry.js";

const DIGITS = 30;

/** The call in every language: `{curl, python, matlab}`. */
export function callsOf(geometry, l1) {
  const base = address("").replace(/\/$/, "");
  return { curl: curl(base, geometry, l1), python: python(base, geometry, l1), matlab: matlab(base, geometry, l1) };
}

function curl(base, geometry, l1) {
  const body = `{
    "geometry": ${JSON.stringify(geometry).replaceAll('":', '": ').replaceAll(',"', ', "')},
    "l1": ${JSON.stringify(l1)}, "digits": ${DIGITS}}`;
  const header = key.get() ? ' -H "Authorization: Bearer $RPR_CUSPS_API_KEY"' : "";
  return `curl ${base}/v1/cusp-tables -H 'Prefer: wait=10'${header} \\
  -H 'Content-Type: application/json' -d '${body.replaceAll("'", "'\\''")}'`;
}

function python(base, geometry, l1) {
  const lengths = LENGTHS.map((name) => JSON.stringify(geometry[name])).join(", ");
  return `from rpr_solver import Manipulator
from service.client import ServiceClient, cusp_table

manipulator = Manipulator(${lengths}, "${geometry.orientation}")
with ServiceClient("${base}") as client:
    [slice_] = client.ask(cusp_table(manipulator, ${JSON.stringify(l1)}, digits=${DIGITS})).document["slices"]
for cusp in slice_["cusps"]:
    print(cusp["l2"], cusp["l3"])`;
}

function matlab(base, geometry, l1) {
  const text = (value) => `'${String(value).replaceAll("'", "''")}'`;
  const query = [...LENGTHS, "orientation"].map((name) => `'${name}', ${text(geometry[name])}`);
  const header = key.get() ? `, ...\n    'HeaderFields', {'Authorization', ['Bearer ' getenv('RPR_CUSPS_API_KEY')]}` : "";
  return `options = weboptions('ContentType', 'table', 'Timeout', 15${header});
cusps = webread('${base}/v1/cusp-tables', ...
    ${query.slice(0, 3).join(", ")}, ...
    ${query.slice(3).join(", ")}, ...
    'l1', ${text(l1)}, 'digits', '15', 'format', 'csv', options)`;
}

/** The tabs with the calls. */
export class Calls {
  #tabs = [...document.querySelectorAll("#calls [role=tab]")];
  #code = document.getElementById("code");
  #texts = {};
  #language = "curl";

  constructor() {
    this.#tabs.forEach((tab, k) => {
      tab.addEventListener("click", () => this.#open(k));
      tab.addEventListener("keydown", (event) => {
        const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (by) this.#open((k + by + this.#tabs.length) % this.#tabs.length, true);
      });
    });
  }

  get text() {
    return this.#texts[this.#language];
  }

  show(geometry, l1) {
    this.#texts = callsOf(geometry, l1);
    this.#code.textContent = this.text;
  }

  #open(index, isFocused = false) {
    this.#tabs.forEach((tab, k) => {
      tab.setAttribute("aria-selected", String(k === index));
      tab.tabIndex = k === index ? 0 : -1;
    });
    this.#language = this.#tabs[index].dataset.language;
    document.getElementById("code-panel").setAttribute("aria-labelledby", this.#tabs[index].id);
    if (isFocused) this.#tabs[index].focus();
    this.#code.textContent = this.text;
  }
}
