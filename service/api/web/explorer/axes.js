/** The frame of a slice, as the figures have it: ticks and names of axes, letters of cusps. */

import { pixel, symbol } from "./board.js";
import { shape } from "./dom.js";

export const ROOM = { left: 66, right: 14, top: 12, bottom: 43 };
const PAD = 8; // pixels from the room to the frame
export const EXACT = { left: ROOM.left - PAD, right: ROOM.right - PAD, top: ROOM.top - PAD, bottom: ROOM.bottom - PAD };
const [NEAR, FAR] = [15, 60]; // pixels between cusps that are one group, and at most if their names leave no room
const [WIDE, TALL] = [9.5, 15]; // a letter of a name
const TURNS = [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [1, 0], [-1, 0], [0, 1]];

export function plotOf(board) {
  return { left: EXACT.left, right: board.canvasWidth - EXACT.right, top: EXACT.top, bottom: board.canvasHeight - EXACT.bottom };
}

/** Ticks and names of the axes; angles have round parts of the turn. */
export function axes(board, names, isAngle) {
  const { left, right, top, bottom } = plotOf(board);
  const [x0, y1, x1, y0] = board.getBoundingBox();
  const marks = [shape("rect", { class: "axis", x: left, y: top, width: Math.max(right - left, 0), height: Math.max(bottom - top, 0) })];
  for (const value of ticksOf(x0, x1, board.canvasWidth / 70, isAngle)) {
    const [x] = pixel(board, [value, 0]);
    const text = tickText(value, isAngle);
    const at = { x: Math.min(x, board.canvasWidth - 3.5 * text.length), y: bottom + 16, "text-anchor": "middle" };
    if (x >= left - 1 && x <= right + 1) marks.push(...tick(`M${x} ${bottom}v5`, text, at));
  }
  for (const value of ticksOf(y0, y1, board.canvasHeight / 45, isAngle)) {
    const [, y] = pixel(board, [0, value]);
    if (y >= top && y <= bottom) marks.push(...tick(`M${left} ${y}h-5`, tickText(value, isAngle), { x: left - 7, y: y + 4, "text-anchor": "end" }));
  }
  if (isAngle) marks.push(...seams(board));
  marks.push(symbol(names[0], { class: "axis-name", x: (left + right) / 2, y: bottom + 29, "text-anchor": "middle" }));
  const across = `translate(11 ${(top + bottom) / 2}) rotate(-90)`;
  marks.push(symbol(names[1], { class: "axis-name", transform: across, "text-anchor": "middle" }));
  return marks;
}

/** The sides of the torus that are in view; arrows of one kind are on opposite sides, which are one line. */
function seams(board) {
  const plot = plotOf(board);
  const [[left, top], [right, bottom], [across, upward]] = [[-180, 180], [180, -180], [22, 22]].map((corner) => pixel(board, corner));
  const isSeen = { left: left > plot.left - 1, right: right < plot.right + 1, top: top > plot.top - 1, bottom: bottom < plot.bottom + 1 };
  const sides = {
    left: [`M${left} ${top}V${bottom}`, `M${left - 4} ${upward + 4}l4 -8l4 8z`],
    right: [`M${right} ${top}V${bottom}`, `M${right - 4} ${upward + 4}l4 -8l4 8z`],
    top: [`M${left} ${top}H${right}`, `M${across - 8} ${top - 4}l8 4l-8 4zm8 0l8 4l-8 4z`],
    bottom: [`M${left} ${bottom}H${right}`, `M${across - 8} ${bottom - 4}l8 4l-8 4zm8 0l8 4l-8 4z`],
  };
  const what = "Opposite sides, with the same arrows, are the same line: 180° is −180°";
  const shown = Object.keys(sides).filter((side) => isSeen[side]).flatMap((side) => sides[side].map((d, k) => ({ d, class: ["seam", "arrow"][k] })));
  return shown.map((attributes) => shape("path", { ...attributes, "data-what": what }));
}

function tick(d, text, at) {
  return [shape("path", { class: "axis", d }), shape("text", { class: "tick-label", ...at }, text)];
}

export function ticksOf(low, high, most, isAngle) {
  const rough = (high - low) / Math.max(most, 2);
  const power = 10 ** Math.floor(Math.log10(rough));
  const round = isAngle && rough > 12 ? [15, 30, 45, 60, 90, 180] : [1, 2, 5, 10].map((digit) => digit * power);
  const step = round.find((size) => size >= rough) ?? round.at(-1);
  const ticks = [];
  for (let k = Math.ceil(low / step); k * step <= high && ticks.length < 50; k += 1) ticks.push(k * step);
  return isAngle ? ticks.filter((value) => Math.abs(value) <= 180) : ticks;
}

export function tickText(value, isAngle) {
  const rounded = Number(value.toPrecision(10));
  const size = Math.abs(rounded);
  const text = size === 0 || (size >= 1e-3 && size < 1e5) ? String(rounded) : rounded.toExponential();
  return text.replaceAll("-", "−").replace("e+", "e") + (isAngle ? "°" : "");
}

/**
 * Names beside their marks, none over another: `[{x, y, text, members, radius}]`. Cusps too near to each other
 * to be told apart, or to be named, are one group with the radius of a circle round it.
 */
export function namesOf(places, names, box) {
  let groups = places.map((place, k) => ({ members: [k], ...place }));
  for (;;) {
    let one = groups.findIndex((_, k) => nearest(groups, k, NEAR) >= 0);
    const found = one < 0 ? placed(groups, places, names, box) : [];
    if (one < 0) one = found.findIndex(({ isFree }) => !isFree);
    const other = one < 0 ? -1 : nearest(groups, one, FAR);
    if (other < 0) return found;
    groups = [...groups.filter((_, k) => k !== one && k !== other), merged(groups[one], groups[other])];
  }
}

const gap = (one, other) => Math.hypot(one.x - other.x, one.y - other.y) - (one.radius ?? 0) - (other.radius ?? 0);

/** The circle round two marks or circles. */
function merged(one, other) {
  const [r, s] = [one.radius ?? 0, other.radius ?? 0];
  const apart = Math.hypot(one.x - other.x, one.y - other.y);
  const radius = Math.max(r, s, (apart + r + s) / 2);
  const share = apart > 0 ? Math.min(Math.max((radius - r) / apart, 0), 1) : 0;
  const members = [...one.members, ...other.members].sort((a, b) => a - b);
  return { members, radius, x: one.x + share * (other.x - one.x), y: one.y + share * (other.y - one.y) };
}

function nearest(groups, index, most) {
  const gaps = groups.map((group, k) => (k === index ? Infinity : gap(group, groups[index])));
  const least = Math.min(...gaps);
  return least < most ? gaps.indexOf(least) : -1;
}

function placed(groups, places, names, box) {
  const blocked = [];
  const discs = [...places.map(({ x, y }) => around(x, y, 14, 14)), ...groups.filter(({ radius }) => radius).map(({ x, y, radius }) => around(x, y, 2 * radius + 14, 2 * radius + 14))];
  return groups.map((group) => {
    const text = textOf(group.members, names);
    const [w, h] = [text.length * WIDE * (text.length > 2 ? 0.8 : 1), TALL];
    const reach = (group.radius ?? 0) + 10;
    const own = discs.filter((disc) => !(group.radius && inside(disc, group)));
    const options = [1, 1.7, 2.6].flatMap((far) => TURNS.map(([dx, dy]) => {
      const slant = dx && dy ? 0.75 : 1;
      return around(group.x + dx * (far * reach * slant + w / 2), group.y + dy * (far * reach * slant + h / 2), w, h);
    }));
    const costs = options.map((option, k) => {
      const isOut = option.left < box.left || option.right > box.right || option.top < box.top || option.bottom > box.bottom;
      return k / 100 + (isOut ? 20 : 0) + (blocked.some((other) => overlap(option, other)) ? 10 : 0) + (own.some((disc) => overlap(option, disc)) ? 4 : 0);
    });
    const best = costs.indexOf(Math.min(...costs));
    blocked.push(options[best]);
    const { left, right, top, bottom } = options[best];
    return { ...group, text, at: [(left + right) / 2, (top + bottom) / 2], isFree: costs[best] < 10 };
  });
}

const around = (x, y, w, h) => ({ left: x - w / 2, right: x + w / 2, top: y - h / 2, bottom: y + h / 2 });
const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
const inside = (disc, { x, y, radius }) => Math.hypot((disc.left + disc.right) / 2 - x, (disc.top + disc.bottom) / 2 - y) <= radius + 1;

/** A, or A, B, or A … F. */
function textOf(members, names) {
  const letters = members.map((k) => names[k]);
  return letters.length > 4 ? `${letters[0]} … ${letters.at(-1)}` : letters.join(", ");
}
