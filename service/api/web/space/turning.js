/** Pointers, fingers and keys that turn, move and magnify a picture, or point to something in it. */

import { on } from "../explorer/dom.js";

const DEGREES = 0.45; // that a pixel turns
const STEP = 5; // degrees that a key turns
const ZOOM = 1.25; // of a key
const WHEEL = 0.0015;
const STILL = 4; // pixels that a click may move
const REACH = { mouse: 9, pen: 12, touch: 18 }; // pixels from a click to what it means

/** `onMove()` is told that the camera was moved, `onPick(x, y, reach)` a click, `onHover(x, y, reach)` where the pointer is. */
export function bindTurning(board, camera, { onMove, onPick, onHover }) {
  const held = new Map(); // places of pointers
  let [far, isPan] = [0, false];
  const place = (event) => {
    const { left, top } = board.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  on(board, "pointerdown", (event) => {
    board.setPointerCapture(event.pointerId);
    if (held.size === 0) [far, isPan] = [0, event.shiftKey || event.button > 0];
    held.set(event.pointerId, place(event));
    if (held.size > 1) far = Infinity;
  });
  on(board, "pointermove", (event) => {
    const before = held.get(event.pointerId);
    const [x, y] = place(event);
    if (!before) return onHover(x, y, REACH[event.pointerType] ?? REACH.mouse);
    const [dx, dy] = [x - before[0], y - before[1]];
    far += Math.hypot(dx, dy);
    if (held.size === 2) {
      const [other] = [...held].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = ([u, v]) => Math.hypot(u - other[0], v - other[1]);
      camera.pan(dx / 2, dy / 2);
      camera.zoomAbout(apart([x, y]) / Math.max(apart(before), 1), (x + other[0]) / 2, (y + other[1]) / 2);
    } else if (isPan) camera.pan(dx, dy);
    else camera.turn(-DEGREES * dx, DEGREES * dy);
    held.set(event.pointerId, [x, y]);
    return onMove();
  });
  const release = (event) => {
    const isClick = held.delete(event.pointerId) && event.type === "pointerup" && far < STILL && event.button === 0;
    if (isClick) onPick(...place(event), REACH[event.pointerType] ?? REACH.mouse);
  };
  for (const type of ["pointerup", "pointercancel"]) on(board, type, release);
  on(board, "contextmenu", (event) => event.preventDefault());
  on(board, "wheel", (event) => {
    event.preventDefault();
    camera.zoomAbout(Math.exp(-WHEEL * Math.max(Math.min(event.deltaY * (event.deltaMode ? 30 : 1), 300), -300)), ...place(event));
    onMove();
  }, { passive: false });
  on(board, "keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const [way] = [{ ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key]];
    const magnified = { "+": ZOOM, "=": ZOOM, "-": 1 / ZOOM, _: 1 / ZOOM }[event.key];
    if (way) event.shiftKey ? camera.pan(-20 * way[0], 20 * way[1]) : camera.turn(STEP * way[0], STEP * way[1]);
    else if (magnified) camera.zoomAbout(magnified);
    else if (event.key === "0") camera.showAll();
    else return;
    event.preventDefault();
    onMove();
  });
}
