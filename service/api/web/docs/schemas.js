/** Schemas of the contract as lists of their members; those of a member open below it. */

import { make } from "../explorer/dom.js";
import { inline } from "./text.js";

let components = {};

/** Reads references from a contract. */
export function readFrom(contract) {
  components = contract;
}

/** What stands at a reference, or the value itself. */
export function resolved(value) {
  if (!value?.$ref) return value ?? {};
  return value.$ref.slice(2).split("/").reduce((part, name) => part[name], components);
}

const nameOf = (schema) => schema.$ref?.split("/").pop();
const without = (options) => options.filter((option) => option.type !== "null");
const optionsOf = (schema) => without(schema.anyOf ?? schema.oneOf ?? []);

/** The type of a value in words. */
export function typeOf(schema) {
  if (schema.$ref) return nameOf(schema);
  if ("const" in schema) return JSON.stringify(schema.const);
  if (schema.enum) return schema.enum.map((value) => JSON.stringify(value)).join(" | ");
  const options = optionsOf(schema);
  if (options.length) return [...new Set(options.map(typeOf))].join(" or ");
  if (schema.type === "array") return `list of ${typeOf(schema.items ?? {})}`;
  const ends = [["≥", schema.minimum], [">", schema.exclusiveMinimum], ["≤", schema.maximum]];
  return [[schema.type ?? "any"].flat().join(" or "), ...ends.filter(([, end]) => end !== undefined).map((end) => end.join(" "))].join(" ");
}

/** The schemas of objects within a value: itself, an option of it, or an element of a list. */
function objectsIn(schema) {
  const whole = resolved(schema);
  if (whole.properties) return [[nameOf(schema) ?? "members", whole]];
  if (whole.type === "array") return objectsIn(whole.items ?? {});
  return optionsOf(whole).flatMap(objectsIn);
}

/** The members of an object. */
export function members(schema) {
  const { properties = {}, required = [] } = resolved(schema);
  const list = make("dl");
  for (const [name, member] of Object.entries(properties)) list.append(...item(name, member, required.includes(name)));
  return list;
}

/** A member or a parameter, and what is in it. */
export function item(name, schema, isRequired, text) {
  const term = make("dt", {}, make("code", { textContent: name }), " ", make("small", { textContent: typeOf(schema) }));
  if (isRequired) term.append(" ", make("b", { textContent: "required" }));
  const said = text ?? schema.description ?? resolved(schema).description ?? "";
  const initial = schema.default ?? null;
  const about = make("dd", {}, make("p", {}, ...inline(said), ...(initial === null ? [] : [` Default: ${JSON.stringify(initial)}.`])));
  for (const [label, inner] of objectsIn(schema)) {
    const below = make("details", {}, make("summary", { textContent: label }));
    below.addEventListener("toggle", () => below.append(members(inner)), { once: true }); // some contain themselves
    about.append(below);
  }
  return [term, about];
}
