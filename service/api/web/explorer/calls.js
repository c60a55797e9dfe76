/** "Call this": what is shown, as a call of another program. */

import { address, key } from "./api.js";
import { byId, copy, on } from "./dom.js";
import { LENGTHS, isSix } from "./geometry.js";
import { bindTabs } from "./panel.js";
import { letterOf } from "./state.js";

/**
 * What can be called: the question's path; its members beside the geometry; the function of the library and of the
 * Python client, with the number of members that it takes by place; what a program prints, and a notebook shows.
 */
const QUESTIONS = {
  cusps: {
    path: "v1/cusp-tables", name: "cusp_table", placed: 1, part: "[0]",
    members: ({ l1 }) => ({ l1, digits: 30 }),
    print: 'for cusp in answer["slices"][0]["cusps"]:\n    print(cusp["l2"], cusp["l3"])',
  },
  curves: {
    path: "v1/singular-curves", name: "singular_curves", placed: 1,
    members: ({ l1 }) => ({ l1 }),
    print: 'for region in answer["regions"]:\n    print(region["poses"], region["point"])',
  },
  loop: {
    path: "v1/paths", name: "cusp_loop", placed: 2,
    members: ({ l1, cusp }) => ({ l1, cusp: letterOf(cusp), samples: 101 }),
    print: 'for sample in answer["samples"]:\n    print(sample["time"], sample["l2"], sample["l3"])',
  },
  poses: {
    path: "v1/poses", name: "poses", placed: 3,
    members: ({ l1, at: { l2, l3 } }) => ({ l1, l2, l3, digits: 30 }),
    print: 'for pose in answer["poses"]:\n    print(pose["alpha_deg"], pose["theta1_deg"])',
  },
  census: {
    path: "v1/censuses", name: "census", placed: 0,
    members: () => ({ digits: 30 }),
    print: 'for window in answer["intervals"]:\n    print(window["from"], window["to"], window["count"])',
  },
  margin: {
    path: "v1/margins", name: "margin", placed: 1,
    members: ({ l1, tolerance }) => ({ l1, tolerance }),
    print: 'print(answer["verdict"], answer["counterexample"])',
  },
  design: {
    path: "v1/designs", name: "design", placed: 2,
    members: ({ wish }) => wish,
    print: 'print(answer["best"]["value"], answer["best"]["geometry"])',
  },
};

const base = () => address("").replace(/\/$/, "");

/** The names that Python imports from the library, the manipulator, and the call. */
function called({ name, placed, members }, { geometry, ...state }) {
  const values = Object.entries(members(state)).map(([member, value], k) => (k < placed ? literal(value) : `${member}=${literal(value)}`));
  const six = () => `Manipulator(${LENGTHS.map((length) => literal(geometry[length])).join(", ")}, "${geometry.orientation}")`;
  const made = `manipulator = ${isSix(geometry) ? six() : `Manipulator.from_json(${spaced(geometry)})`}`;
  const names = ["Manipulator", ...(name === "design" ? ["Requirement"] : [])];
  return { names, made, text: `${name}(${["manipulator", ...values].join(", ")})` };
}

/** A value in Python; requirements and budgets are no texts or numbers. */
function literal(value) {
  if (value.censuses) return value.censuses;
  if (!value.range) return JSON.stringify(value);
  const { range: { from, to }, ...counts } = value;
  return `Requirement(start=${literal(from)}, stop=${literal(to)}, ${Object.entries(counts).map((count) => count.join("=")).join(", ")})`;
}

function notebook(question, state) {
  const { names, made, text } = called(question, state);
  return `from rpr_solver import ${[...names, question.name].join(", ")}\n\n${made}\n${text}${question.part ?? ""}`;
}

const spaced = (value) => JSON.stringify(value).replaceAll('":', '": ').replaceAll(',"', ', "').replaceAll(",[", ", [");

function curl({ path, members }, state) {
  const rest = spaced(members(state)).slice(1);
  const body = `{\n    "geometry": ${spaced(state.geometry)},\n    ${rest}`;
  const header = key.get() ? ' -H "Authorization: Bearer $RPR_CUSPS_API_KEY"' : "";
  return `curl ${base()}/${path} -H 'Prefer: wait=10'${header} \\
  -H 'Content-Type: application/json' -d '${body.replaceAll("'", "'\\''")}'`;
}

function python(question, state) {
  const { names, made, text } = called(question, state);
  return `from rpr_solver import ${names.join(", ")}
from service.client import ServiceClient, ${question.name}

${made}
with ServiceClient("${base()}") as client:
    answer = client.ask(${text}).document
${question.print}`;
}

function matlab({ path, members }, state) {
  const text = (x) => (typeof x === "number" ? x : `'${String(x).replaceAll("'", "''")}'`);
  const cells = (x) => (Array.isArray(x) ? `{${x.map(cells).join(", ")}}` : text(x));
  const value = (x) => (Array.isArray(x) ? `{${cells(x)}}` : typeof x === "object" ? `struct(${struct(x)})` : text(x));
  const struct = (object) => Object.entries(object).map(([name, x]) => `'${name}', ${value(x)}`).join(", ");
  const fields = [["Prefer", "'wait=10'"]];
  if (key.get()) fields.push(["Authorization", "['Bearer ' getenv('RPR_CUSPS_API_KEY')]"]);
  const headers = fields.map(([name, x]) => `'${name}', ${x}`).join("; ");
  return `geometry = struct(${struct(state.geometry)});
question = struct('geometry', geometry, ${struct(members(state))});
options = weboptions('MediaType', 'application/json', 'Timeout', 15, 'HeaderFields', {${headers}});
answer = webwrite('${base()}/${path}', question, options)`;
}

export class Calls {
  #state = null;
  #language = "notebook";

  constructor() {
    on("question", "change", () => this.#write());
    on("copy-code", "click", () => copy(byId("code").textContent, "The call is copied."));
    bindTabs(document.querySelector("#calls [role=tablist]"), (tab) => {
      this.#language = tab.textContent.toLowerCase();
      byId("code-panel").setAttribute("aria-labelledby", tab.id);
      this.#write();
    });
  }

  show(state) {
    this.#state = state;
    const question = byId("question");
    question.querySelector("[value=poses]").disabled = !state.at;
    if (!state.at && question.value === "poses") question.value = "cusps";
    this.#write();
  }

  #write() {
    const write = { notebook, curl, python, matlab }[this.#language];
    if (this.#state) byId("code").textContent = write(QUESTIONS[byId("question").value], this.#state);
  }
}
