/** "Call this": what is shown, as a call of another program. */

import { address, key } from "./api.js";
import { LENGTHS } from "./geometry.js";
import { bindTabs } from "./panel.js";
import { letterOf } from "./state.js";

/**
 * What can be called: the question's path, its members, how the Python client asks it and prints the answer, and
 * how the library does in a notebook, which draws what is in the last line.
 */
const QUESTIONS = {
  cusps: {
    path: "v1/cusp-tables",
    notebook: ({ l1 }) => `[table] = cusp_table(manipulator, ${JSON.stringify(l1)})\ntable`,
    members: ({ l1 }) => ({ l1, digits: 30 }),
    python: ({ l1 }) => ({
      ask: ["cusp_table", [JSON.stringify(l1), "digits=30"]],
      print: 'for cusp in answer["slices"][0]["cusps"]:\n    print(cusp["l2"], cusp["l3"])',
    }),
  },
  curves: {
    path: "v1/singular-curves",
    notebook: ({ l1 }) => `singular_curves(manipulator, ${JSON.stringify(l1)})`,
    members: ({ l1 }) => ({ l1 }),
    python: ({ l1 }) => ({
      ask: ["singular_curves", [JSON.stringify(l1)]],
      print: 'for region in answer["regions"]:\n    print(region["poses"], region["point"])',
    }),
  },
  loop: {
    path: "v1/paths",
    notebook: ({ l1, cusp }) => `cusp_loop(manipulator, ${JSON.stringify(l1)}, "${letterOf(cusp)}")`,
    members: ({ l1, cusp }) => ({ l1, cusp: letterOf(cusp), samples: 101 }),
    python: ({ l1, cusp }) => ({
      ask: ["cusp_loop", [JSON.stringify(l1), `"${letterOf(cusp)}"`]],
      print: 'for sample in answer["samples"]:\n    print(sample["time"], sample["l2"], sample["l3"])',
    }),
  },
  poses: {
    path: "v1/poses",
    notebook: ({ l1, at }) => `poses(manipulator, ${[l1, at.l2, at.l3].map((length) => JSON.stringify(length)).join(", ")})`,
    members: ({ l1, at }) => ({ l1, l2: at.l2, l3: at.l3, digits: 30 }),
    python: ({ l1, at }) => ({
      ask: ["poses", [...[l1, at.l2, at.l3].map((length) => JSON.stringify(length)), "digits=30"]],
      print: 'for pose in answer["poses"]:\n    print(pose["alpha_deg"], pose["theta1_deg"])',
    }),
  },
  census: {
    path: "v1/censuses",
    notebook: () => "census(manipulator)",
    members: () => ({ digits: 30 }),
    python: () => ({
      ask: ["census", ["digits=30"]],
      print: 'for window in answer["intervals"]:\n    print(window["from"], window["to"], window["count"])',
    }),
  },
  margin: {
    path: "v1/margins",
    notebook: ({ l1, tolerance }) => `margin(manipulator, ${JSON.stringify(l1)}, tolerance=${JSON.stringify(tolerance)})`,
    members: ({ l1, tolerance }) => ({ l1, tolerance }),
    python: ({ l1, tolerance }) => ({
      ask: ["margin", [JSON.stringify(l1), `tolerance=${JSON.stringify(tolerance)}`]],
      print: 'print(answer["verdict"], answer["counterexample"])',
    }),
  },
  design: {
    path: "v1/designs",
    members: ({ wish }) => wish,
    python: ({ wish: { objective, requirement: { range, ...counts }, vary, budget } }) => {
      const bounds = Object.entries(counts).map(([name, count]) => `${name}=${count}`);
      const wanted = [`start=${JSON.stringify(range.from)}`, `stop=${JSON.stringify(range.to)}`, ...bounds].join(", ");
      const options = [`vary=${JSON.stringify(vary)}`, `budget=${budget.censuses}`];
      return {
        names: ["Requirement"],
        ask: ["design", [JSON.stringify(objective), `Requirement(${wanted})`, ...options]],
        print: 'print(answer["best"]["value"], answer["best"]["geometry"])',
      };
    },
  },
};

/** The call of a question in every language: `{notebook, curl, python, matlab}`. */
export function callsOf(name, state) {
  const base = address("").replace(/\/$/, "");
  const question = QUESTIONS[name];
  return { notebook: notebook(question, state), curl: curl(base, question, state), python: python(base, question, state), matlab: matlab(base, question, state) };
}

function made({ geometry }) {
  return `manipulator = Manipulator(${LENGTHS.map((name) => JSON.stringify(geometry[name])).join(", ")}, "${geometry.orientation}")`;
}

function notebook({ notebook: write, python: client }, state) {
  const code = write?.(state);
  if (!code) {
    const { names = [], ask: [name, parameters] } = client(state);
    return `from rpr_solver import ${["Manipulator", ...names, name].join(", ")}\n\n${made(state)}\n${name}(${["manipulator", ...parameters].join(", ")})`;
  }
  return `from rpr_solver import Manipulator, ${code.match(/[a-z_]+(?=\()/)[0]}\n\n${made(state)}\n${code}`;
}

function curl(base, { path, members }, state) {
  const spaced = (value) => JSON.stringify(value).replaceAll('":', '": ').replaceAll(',"', ', "');
  const rest = spaced(members(state)).slice(1);
  const body = `{\n    "geometry": ${spaced(state.geometry)},\n    ${rest}`;
  const header = key.get() ? ' -H "Authorization: Bearer $RPR_CUSPS_API_KEY"' : "";
  return `curl ${base}/${path} -H 'Prefer: wait=10'${header} \\
  -H 'Content-Type: application/json' -d '${body.replaceAll("'", "'\\''")}'`;
}

function python(base, question, state) {
  const { ask: [name, parameters], names = [], print } = question.python(state);
  return `from rpr_solver import ${["Manipulator", ...names].join(", ")}
from service.client import ServiceClient, ${name}

${made(state)}
with ServiceClient("${base}") as client:
    answer = client.ask(${name}(${["manipulator", ...parameters].join(", ")})).document
${print}`;
}

function matlab(base, { path, members }, state) {
  const text = (x) => (typeof x === "number" ? x : `'${String(x).replaceAll("'", "''")}'`);
  const value = (x) => (typeof x === "object" ? `struct(${struct(x)})` : text(x));
  const struct = (object) => Object.entries(object).map(([name, x]) => `'${name}', ${value(x)}`).join(", ");
  const fields = [["Prefer", "'wait=10'"]];
  if (key.get()) fields.push(["Authorization", "['Bearer ' getenv('RPR_CUSPS_API_KEY')]"]);
  const headers = fields.map(([name, x]) => `'${name}', ${x}`).join("; ");
  return `geometry = struct(${struct(state.geometry)});
question = struct('geometry', geometry, ${struct(members(state))});
options = weboptions('MediaType', 'application/json', 'Timeout', 15, 'HeaderFields', {${headers}});
answer = webwrite('${base}/${path}?numbers=float', question, options)`;
}

/** The tabs with the calls. */
export class Calls {
  #code = document.getElementById("code");
  #question = document.getElementById("question");
  #state = null;
  #language = "notebook";

  constructor() {
    this.#question.addEventListener("change", () => this.#write());
    bindTabs(document.querySelector("#calls [role=tablist]"), (tab) => {
      this.#language = tab.dataset.language;
      document.getElementById("code-panel").setAttribute("aria-labelledby", tab.id);
      this.#write();
    });
  }

  get text() {
    return this.#code.textContent;
  }

  show(state) {
    this.#state = state;
    this.#question.querySelector("[value=poses]").disabled = !state.at;
    if (!state.at && this.#question.value === "poses") this.#question.value = "cusps";
    this.#write();
  }

  #write() {
    this.#code.textContent = callsOf(this.#question.value, this.#state)[this.#language];
  }
}
