/** The fields: the geometry and L1 as text, the source of truth, with errors where they belong. */

import { pointed, toNumber } from "./decimals.js";
import { byId, make, on, write } from "./dom.js";
import { LENGTHS } from "./geometry.js";
import { geometryOf, geometryText } from "./state.js";

export class Fields {
  #examples = byId("example");

  /** `onChange({geometry}|{l1}, isExample)` is told each change that the user makes. */
  constructor({ onChange }) {
    on(byId("a2x").form, "input", () => onChange({ geometry: this.geometry }));
    on("l1", "input", () => onChange({ l1: pointed(byId("l1").value) }));
    for (const input of document.querySelectorAll("input.exact")) {
      furnish(input);
      on(input, "input", () => hintOf(input));
      on(input, "change", () => (input.value = pointed(input.value)));
    }
    on(this.#examples, "change", () => {
      const chosen = this.#examples.selectedOptions[0];
      if (chosen.value) onChange(exampleOf(chosen), true);
    });
    for (const form of document.querySelectorAll("form")) on(form, "submit", (event) => event.preventDefault());
  }

  get geometry() {
    const orientation = document.querySelector("input[name=orientation]:checked").value;
    return { ...Object.fromEntries(LENGTHS.map((name) => [name, pointed(byId(name).value)])), orientation };
  }

  /** Shows a state; a field in which somebody writes keeps its text. */
  show({ geometry, l1 }) {
    for (const name of LENGTHS) fill(name, geometry[name]);
    document.querySelector(`input[name=orientation][value=${geometry.orientation}]`).checked = true;
    fill("l1", l1);
    const text = geometryText(geometry);
    const known = [...this.#examples.options].find(({ value }) => value === text);
    this.#examples.value = known?.value ?? "";
  }

  /** What is wrong with a state by itself, `[{field, message}]`: told at once, all of it. */
  static faultsOf({ geometry, l1 }) {
    const lengths = [...LENGTHS.map((name) => [name, geometry[name]]), ["l1", l1]];
    return lengths.flatMap(([field, text]) => {
      const value = toNumber(text);
      if (text === "") return [{ field, message: "is missing; write a decimal such as 17.04" }];
      if (!Number.isFinite(value)) return [{ field, message: `is ${text}, which is no number; write a decimal such as 17.04 or a quotient such as 426/25` }];
      if (field === "l1" && value <= 0) return [{ field, message: `is ${text}; a leg length must be > 0` }];
      return field.startsWith("d") && value <= 0 ? [{ field, message: `is ${text}; a side must be > 0` }] : [];
    });
  }

  /** Shows the errors of a refused question at their fields; returns those of no field here. */
  refuse(errors) {
    this.clear();
    const [own, others] = [[], []];
    for (const error of errors) {
      const input = byId(error.field.replace("geometry.", "").replace(/\[\d+\]$/, ""));
      if (input?.matches("input.exact")) own.push([input, error]);
      else others.push(error);
    }
    for (const [input, { message }] of own) {
      const sentence = message.replace(`${input.id}: `, "");
      mark(input.id, sentence.startsWith("is ") ? `${input.id} ${sentence}` : sentence);
    }
    if (own.length && !document.activeElement?.matches("input.exact")) own[0][0].focus();
    return others;
  }

  clear() {
    for (const { id } of document.querySelectorAll("input.exact[aria-invalid]")) mark(id, "");
  }
}

export function firstExample() {
  return exampleOf(byId("example").querySelector("option[data-l1]"));
}

function exampleOf(option) {
  return { geometry: geometryOf(option.value), l1: option.dataset.l1, cusp: 0, at: null, limits: null };
}

/** Shows a number in a field, unless it is what stands there with a decimal comma. */
export function fill(id, text) {
  if (pointed(byId(id).value) !== text) byId(id).value = text;
}

/** Gives a field of an exact number a place for what is wrong with it. */
function furnish(input) {
  const error = make("p", { id: `${input.id}-error`, className: "error" });
  const label = input.closest("label") ?? input;
  const cell = make("div");
  label.replaceWith(cell);
  cell.append(label, error);
  Object.assign(input, { inputMode: "decimal", autocomplete: "off", spellcheck: false });
  input.setAttribute("aria-describedby", error.id);
}

/** Marks a field as wrong and says why; an empty reason takes it back. */
export function mark(id, reason) {
  const error = byId(`${id}-error`);
  byId(id).ariaInvalid = reason ? true : null;
  error.classList.remove("note");
  write(error.id, reason);
  if (reason) error.scrollIntoView({ block: "nearest" });
}

/** Says how a decimal comma is read. */
function hintOf(input) {
  const note = byId(`${input.id}-error`);
  const isComma = pointed(input.value) !== input.value.trim();
  if (isComma) note.textContent = `The comma is read as a decimal point: ${pointed(input.value)}`;
  else if (note.classList.contains("note")) note.textContent = "";
  note.classList.toggle("note", isComma);
}
