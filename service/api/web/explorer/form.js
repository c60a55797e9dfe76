/** The fields: the geometry and L1 as text, the source of truth, with errors where they belong. */

import { pointed, toNumber } from "./decimals.js";
import { byId, make, on, write } from "./dom.js";
import { FORMS, LENGTHS, formOf, isSix, numbersOf, pairOf, respelled, triangleOf } from "./geometry.js";
import { geometryOf, geometryText } from "./state.js";

const TRIANGLES = ["base", "platform"];

export class Fields {
  #examples = byId("example");
  #shown = null; // the geometry

  /** `onChange({geometry}|{l1}, isExample)` is told each change that the user makes. */
  constructor({ onChange }) {
    on(byId("a2x").form, "input", ({ target }) => {
      const { triangle } = target.dataset;
      onChange({ geometry: triangle ? respelled(this.#shown, triangle, target.value) : this.geometry });
    });
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
    const forms = TRIANGLES.map((name) => document.querySelector(`[data-triangle=${name}]:checked`).value);
    if (forms[0] === "lengths") return { ...Object.fromEntries(LENGTHS.map((name) => [name, textIn(name)])), orientation };
    const [base, platform] = TRIANGLES.map((name, k) => triangleOf(forms[k], fieldsOf(name, forms[k]).map(textIn)));
    return platform.points ? { base, platform } : { base, platform, orientation };
  }

  /** Shows a state; a field in which somebody writes keeps its text. */
  show({ geometry, l1 }) {
    this.#shown = geometry;
    const forms = isSix(geometry) ? ["lengths", "sides"] : TRIANGLES.map((name) => formOf(geometry[name]));
    for (const [k, name] of TRIANGLES.entries()) {
      document.querySelector(`[data-triangle=${name}][value=${forms[k]}]`).checked = true;
      for (const fields of document.querySelectorAll(`[data-of=${name}]`)) fields.hidden = fields.dataset.form !== forms[k];
    }
    for (const [field, text] of numbersIn(geometry)) fill(field, text);
    byId("orientation").hidden = forms[1] === "points";
    if (geometry.orientation) document.querySelector(`input[name=orientation][value=${geometry.orientation}]`).checked = true;
    fill("l1", l1);
    const text = geometryText(geometry);
    const known = [...this.#examples.options].find(({ value }) => value === text);
    this.#examples.value = known?.value ?? "";
  }

  /** What is wrong with a state by itself, `[{field, message}]`: told at once, all of it. */
  static faultsOf({ geometry, l1 }) {
    return [...numbersIn(geometry), ["l1", l1]].flatMap(([field, text]) => {
      const value = toNumber(text);
      if (text === "") return [{ field, message: "is missing; write a decimal such as 17.04" }];
      if (!Number.isFinite(value)) return [{ field, message: `is ${text}, which is not a number; write a decimal such as 17.04, a quotient such as 426/25, or a root such as 5*sqrt(3)/2` }];
      if (field === "l1" && value <= 0) return [{ field, message: `is ${text}; a leg length must be > 0` }];
      // a side of a triangle is 0 where legs share a joint
      const isWrong = /^d|\.sides/.test(field) ? value < 0 : /\.equilateral/.test(field) && value <= 0;
      return isWrong ? [{ field, message: `is ${text}; a side must be > 0` }] : [];
    });
  }

  /** Shows the errors of a refused question at their fields; returns those of no field here. */
  refuse(errors) {
    this.clear();
    const [own, others] = [[], []];
    for (const error of errors) {
      const input = inputOf(error.field);
      if (input) own.push([input, error]);
      else others.push(error);
    }
    for (const [input, { message }] of own) {
      const name = input.dataset.name ?? input.id;
      const sentence = message.replace(`${input.id}: `, "").replaceAll(/geometry\.[\w.[\]]+/g, (field) => inputOf(field)?.dataset.name ?? field);
      mark(input.id, sentence.startsWith("is ") ? `${name} ${sentence}` : sentence);
    }
    if (own.length && !document.activeElement?.matches("input.exact")) own[0][0].focus();
    return others;
  }

  clear() {
    for (const { id } of document.querySelectorAll("input.exact[aria-invalid]")) mark(id, "");
  }
}

/** The ids of the fields of a triangle; sides of the platform are the lengths d1, d2, d3. */
function fieldsOf(name, form) {
  return name === "platform" && form === "sides" ? LENGTHS.slice(3) : FORMS[form].map((place) => `${name}.${form}${place}`);
}

/** The numbers of a geometry by their fields: `[[id, text], …]`. */
function numbersIn(geometry) {
  if (isSix(geometry)) return LENGTHS.map((name) => [name, geometry[name]]);
  const pair = pairOf(geometry);
  return TRIANGLES.flatMap((name) => {
    const texts = numbersOf(pair[name]);
    return fieldsOf(name, formOf(pair[name])).map((field, k) => [field, texts[k]]);
  });
}

/** The field that the service means: that of a number, or the first of a corner, a triangle or a list. */
function inputOf(field) {
  const path = field.replace("geometry.", "");
  const name = path.replace(/^platform\.sides\[(\d)\]$/, (_, k) => `d${Number(k) + 1}`);
  const shown = [...document.querySelectorAll("input.exact")].filter((input) => !input.closest("[data-of][hidden]"));
  const exact = shown.find(({ id }) => id === name || id === name.replace(/\[\d+\]$/, ""));
  return exact ?? shown.find((input) => input.id.startsWith(`${name}[`) || input.closest("[data-of]")?.dataset.of === path);
}

const textIn = (id) => pointed(byId(id).value);

export function firstExample() {
  return exampleOf(byId("example").querySelector("option[data-l1]"));
}

function exampleOf(option) {
  return { geometry: geometryOf(option.value), l1: option.dataset.l1, cusp: 0, at: null, limits: null, home: null };
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
