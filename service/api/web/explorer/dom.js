/** Elements of the page: found, made, and what is said of them. */

const SVG = "http://www.w3.org/2000/svg";

export const byId = (id) => document.getElementById(id);

/** Listens to an element, or to the one of an id. */
export const on = (target, ...rest) => (byId(target) ?? target).addEventListener(...rest);

/** An element with properties and children. */
export function make(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

export function shape(name, attributes = {}, text = "") {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== "") node.textContent = text;
  return node;
}

/** Writes a text where it is another one: what stays the same need not be laid out again. */
export function write(id, text) {
  if (byId(id).textContent !== text) byId(id).textContent = text;
}

/** Says a sentence to screen readers. */
export function say(sentence) {
  byId("live").textContent = sentence;
}

export async function copy(text, done) {
  try {
    await navigator.clipboard.writeText(text);
    say(done);
  } catch {
    say("This browser does not allow the page to copy.");
  }
}
