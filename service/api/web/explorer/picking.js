/** The pointer in the slice: a click takes a place, a drag draws joint limits. */

import { decimal, gridPlaces } from "./decimals.js";
import { on } from "./dom.js";

const STILL = 4; // pixels that a click may move

/**
 * Binds a board. `onPlace([x, y])` is told a place on the grid of decimals that pixels tell apart; if `isDrawing()`, `onDraft({l2, l3})` each rectangle while it is dragged, and `onLimits({l2, l3})` the last one.
 */
export function bindPicking(board, { isDrawing, onDraft, onLimits, onPlace }) {
  const container = board.containerObj;
  let start = null;
  const place = (event) => board.getUsrCoordsOfMouse(event).map((x, k) => decimal(x, gridPlaces(1000 / [board.unitX, board.unitY][k])));
  const rectangle = (event) => {
    const ends = [place(start), place(event)];
    const side = (k) => {
      const [min, max] = ends.map((end) => Math.max(Number(end[k]), 0)).sort((a, b) => a - b);
      return { min: String(min), max: String(max) };
    };
    return { l2: side(0), l3: side(1) };
  };
  on(container, "pointerdown", (event) => {
    start = event;
    if (!isDrawing()) return;
    event.stopImmediatePropagation(); // else the picture would move along
    container.setPointerCapture(event.pointerId);
  }, true);
  on(container, "pointermove", (event) => {
    if (isDrawing() && event.buttons && start) onDraft(rectangle(event));
  });
  on(container, "click", (event) => {
    const isStill = start && Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) < STILL;
    if (isDrawing() && start && !isStill) onLimits(rectangle(event));
    if (!isStill || event.target.closest("[data-cusp], [data-vector]")) return;
    onPlace(place(event));
  });
}
