/** Round the picture of the slice: the number of cusps, the legend, and why there is no picture. */

import { counted } from "./census.js";
import { byId, make, write } from "./dom.js";

const REASONS = [
  [/every pose of this slice is singular/, "Every pose of this length is singular: the platform is nowhere held, so that there is no curve to draw."],
  [/whole lines? theta/, "The curve has whole lines on which leg 1 keeps its direction. They are not drawn."],
  [/double precision|told apart|do not close/, "Here curves lie so near to each other, or on each other, that a drawing cannot tell its regions apart. A length near by may have a picture."],
  [/not rational|repeated component/, "The curves of this slice lie on each other. They are not drawn."],
];

/** Shows how many cusps a slice has. */
export function showCount({ l1, count, error }) {
  const text = error ? "no answer" : counted(count);
  if (byId("count").textContent === `L1 = ${l1}: ${text}`) return;
  byId("count").replaceChildren(make("span", { textContent: `L1 = ${l1}: ` }), text);
}

/** Dims the last picture and says why a slice has none, in words that are not the solver's; an empty reason takes it back. */
export function lack(l1, reason, isFirst) {
  byId("slice").classList.toggle("unanswered", Boolean(reason));
  byId("slice-board").inert = Boolean(reason);
  byId("why").hidden = !reason;
  if (!reason) return;
  const words = REASONS.find(([pattern]) => pattern.test(reason))?.[1] ?? "This slice is of a special kind that cannot be drawn.";
  const behind = isFirst ? "" : " Behind this is the last picture, dimmed.";
  write("why-text", `L1 = ${l1} has no picture. ${words}${behind} The table has what is known of this slice.`);
  write("why-detail", `The service says: ${reason}`);
}
