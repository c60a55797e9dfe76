/** Round the picture of the slice: the number of cusps, the legend, and why there is no picture. */

import { counted } from "./census.js";
import { byId, make, write } from "./dom.js";

const REASONS = [
  [/every pose of this slice is singular/, "Every pose of this slice is singular, so there is no curve to draw."],
  [/whole lines? theta/, "The singular curve contains whole lines on which leg 1 keeps its direction, so it is not drawn."],
  [/double precision|told apart|do not close/, "Curves are so close together here, or coincide, that a drawing cannot separate its regions. Try a slightly different length."],
  [/not rational|repeated component/, "The curves of this slice coincide, so they are not drawn."],
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
  write("why-text", `L1 = ${l1} has no picture. ${words}${behind} The table shows what is known about this slice.`);
  write("why-detail", `The service says: ${reason}`);
}
