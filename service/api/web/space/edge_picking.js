/** Which line is meant: by a place on the screen, or by one in (L1, L2, L3). */

/** The line, and the place on it, that is drawn nearest to (x, y), at most so many pixels away; null if none is. */
export function edgeAt(lines, camera, x, y, reach) {
  const matrix = camera.matrix;
  let best = null;
  lines.forEach((line, k) => {
    let before = null;
    line.points.forEach((place, n) => {
      const seen = camera.project(place, matrix);
      if (before) {
        const { share, away } = nearest(before, seen, [x, y], 2);
        if (away <= (best?.away ?? reach)) best = { line, k, away, place: line.points[n - 1].map((a, i) => a + share * (place[i] - a)) };
      }
      before = seen;
    });
  });
  return best;
}

/** The number of the line that is nearest to a place, at most so far away; −1 if none is. */
export function edgeNear(lines, place, most) {
  let [best, least] = [-1, most];
  lines.forEach(({ points }, k) => {
    for (let n = 1; n < points.length; n += 1) {
      const { away } = nearest(points[n - 1], points[n], place, 3);
      if (away < least) [best, least] = [k, away];
    }
  });
  return best;
}

/** How far a place is from a piece of a line, and which share of it is before the nearest place. */
function nearest(from, to, place, dimensions) {
  let [along, whole] = [0, 0];
  for (let k = 0; k < dimensions; k += 1) {
    along += (place[k] - from[k]) * (to[k] - from[k]);
    whole += (to[k] - from[k]) ** 2;
  }
  const share = whole > 0 ? Math.min(Math.max(along / whole, 0), 1) : 0;
  let square = 0;
  for (let k = 0; k < dimensions; k += 1) square += (from[k] + share * (to[k] - from[k]) - place[k]) ** 2;
  return { share, away: Math.sqrt(square) };
}
