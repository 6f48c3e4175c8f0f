/** The map's points, their names, and sigma round the puck. */

import { placed } from "./labels.js";
import { FONT, haloed, line, tracePath } from "./plot.js";
import { ellipseOf, pointOf, toPixel } from "./scales.js";

/** @typedef {import("./plot.js").Context} Context */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./colors.js").Theme} Theme */
/**
 * @typedef {object} Points
 * @property {Float32Array} places (N, 2)
 * @property {string[]} names
 * @property {import("./colors.js").Mark[]} marks
 * @property {number[]} near opacity of each
 * @property {number | null} selected
 * @property {number} under the pointer, -1 for none
 */

const RADIUS = 5; // of a point, in pixels
const OWN = 7; // half of a cross
const RING = 4; // pixels between the selected point and its ring
const LINE_HEIGHT = 13;
const NAMED = 0.2; // a point that is fainter has no name

/** @type {(points: Points) => number[]} */
const indices = ({ names }) => names.map((_, i) => i);

/**
 * One and two sigma.
 * @type {(context: Context, view: View, middle: [number, number], covariance: Float32Array, colors: Theme) => void}
 */
export function drawEllipse(context, view, middle, covariance, colors) {
  const { major, minor, angle } = ellipseOf(covariance);
  const unit = view.box.width / (view.extent.right - view.extent.left);
  const [x, y] = toPixel(view, middle);
  context.fillStyle = colors.puck;
  context.strokeStyle = colors.puck;
  context.lineWidth = 1.5;
  for (const times of [2, 1]) {
    context.beginPath();
    context.ellipse(x, y, times * major * unit, times * minor * unit, -angle, 0, 2 * Math.PI);
    context.globalAlpha = 0.13;
    context.fill();
    context.globalAlpha = 0.8 / times;
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** The fainter first. @type {(context: Context, view: View, points: Points, colors: Theme) => void} */
export function drawPoints(context, view, points, colors) {
  const { places, marks, near, selected, under } = points;
  const clear = (/** @type {number} */ i) => (i === under || i === selected ? 1 : near[i]);
  for (const i of indices(points).sort((a, b) => clear(a) - clear(b))) {
    const [x, y] = toPixel(view, pointOf(places, i));
    tracePath(context, marks[i].shape, x, y, i === under ? RADIUS + 2 : RADIUS);
    context.globalAlpha = clear(i);
    context.fillStyle = marks[i].color;
    context.fill();
    context.lineWidth = 1;
    context.strokeStyle = colors.outline;
    context.stroke();
    context.globalAlpha = 1;
    if (i !== selected) continue;
    context.beginPath();
    context.arc(x, y, RADIUS + RING, 0, 2 * Math.PI);
    context.lineWidth = 2;
    context.strokeStyle = colors.ink;
    context.stroke();
  }
}

/** A person's own points, as crosses with their names. @type {(context: Context, view: View, places: Float32Array, names: string[], colors: Theme) => void} */
export function drawAdded(context, view, places, names, colors) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "top";
  names.forEach((name, k) => {
    const [x, y] = toPixel(view, pointOf(places, k));
    for (const [width, color] of /** @type {[number, string][]} */ ([
      [6, colors.halo],
      [3, colors.ink],
    ])) {
      context.lineWidth = width;
      line(context, color, x - OWN, y, x + OWN, y);
      line(context, color, x, y - OWN, x, y + OWN);
    }
    haloed(context, name, x + OWN, y + 2, colors, colors.ink);
  });
}

/** Where there is room; the selected one's before all. @type {(context: Context, view: View, points: Points, colors: Theme) => void} */
export function drawNames(context, view, points, colors) {
  const { places, names, near, selected } = points;
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "middle";
  const { left, top, width, height } = view.box;
  const labels = indices(points)
    .sort((a, b) => Number(b === selected) - Number(a === selected))
    .map((i) => {
      const [x, y] = toPixel(view, pointOf(places, i));
      const radius = i === selected ? RADIUS + RING : RADIUS;
      return { i, x, y, radius, width: context.measureText(names[i]).width };
    })
    .filter(({ x, y }) => x >= left && y >= top && x <= left + width && y <= top + height);
  placed(labels, LINE_HEIGHT, view.box).forEach((box, k) => {
    const { i } = labels[k];
    if (!box || near[i] < NAMED) return;
    const color = i === selected ? colors.ink : colors.quiet;
    haloed(context, names[i], box.left, box.top + box.height / 2, colors, color);
  });
}
