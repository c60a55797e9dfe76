/** Descriptions of the contract as elements: paragraphs, lists, code and links of Markdown. */

import { make } from "../explorer/dom.js";

const INLINE = /`([^`]+)`|\[([^\]]+)\]\(([^)\s]+)\)|\*\*([^*]+)\*\*/g;

/** A line of text: code, links and what is bold. */
export function inline(text) {
  const found = [];
  let place = 0;
  for (const match of text.matchAll(INLINE)) {
    const [whole, code, label, href, bold] = match;
    found.push(text.slice(place, match.index));
    if (code !== undefined) found.push(make("code", { textContent: code }));
    else if (label !== undefined) found.push(make("a", { textContent: label, href }));
    else found.push(make("b", { textContent: bold }));
    place = match.index + whole.length;
  }
  return [...found, text.slice(place)];
}

/** A whole description. */
export function prose(text = "") {
  return text.trim().split(/\n\s*\n/).filter(Boolean).map((block) => {
    if (!block.startsWith("- ")) return make("p", {}, ...inline(block));
    return make("ul", {}, ...block.slice(2).split(/\n- /).map((item) => make("li", {}, ...inline(item))));
  });
}
