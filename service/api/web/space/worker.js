/** Computes the surface and its edges while the page goes on. */

import { edgesOf, eventsOf } from "./edges.js";
import { surfaceOf } from "./surface.js";

onmessage = ({ data: { number, task, triangles, leg, reach, grid, document } }) => {
  try {
    const answer = task === "surface" ? surfaceOf(triangles, leg, reach, grid) : { lines: edgesOf(triangles, document, reach), events: eventsOf(document) };
    const moved = task === "surface" ? [answer.positions.buffer, answer.normals.buffer, answer.index.buffer] : [];
    postMessage({ number, answer }, moved);
  } catch (error) {
    postMessage({ number, error: error.message });
  }
};
