/** Two ways from one motion to another over a map: the straight line, the shortest one dashed. */

import { PUCK } from "./plot.js";
import { clamp, pointOf, toPixel } from "./scales.js";

/** @typedef {import("./plot.js").Context} Context */
/** @typedef {import("./scales.js").Point} Point */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./messages.js").Numbers} Numbers */
/** @typedef {import("./messages.js").WaysShown} WaysShown */

/** Where a way is after so many steps, which need not be whole. @type {(way: Numbers, step: number) => Point} */
export function along(way, step) {
  const last = (way.shape[0] ?? 1) - 1;
  const first = clamp(Math.floor(step), 0, Math.max(last - 1, 0));
  const [x0, y0] = pointOf(way.data, first);
  const [x1, y1] = pointOf(way.data, Math.min(first + 1, last));
  const share = step - first;
  return [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
}

/** The step at which the models stand, or a morph is at this frame; null: neither. @type {(ways: WaysShown, frame: number) => number | null} */
export function stepNow({ at, shares, changes }, frame) {
  if (!shares) return at;
  const last = shares.data.length - 1;
  return (shares.data[clamp(Math.round(frame), 0, last)] ?? 0) * (changes?.data.length ?? 0);
}

/** @type {(context: Context, view: View, ways: WaysShown, frame: number, colors: import("./colors.js").Theme) => void} */
export function drawWays(context, view, ways, frame, colors) {
  const { straight, shortest } = ways;
  if (!straight || !shortest) return;
  context.save();
  context.lineJoin = "round";
  trace(context, view, straight, [], colors);
  trace(context, view, shortest, [5, 4], colors);
  const step = stepNow(ways, frame);
  if (step !== null) {
    mark(context, view, along(straight, step), colors.path, colors);
    mark(context, view, along(shortest, step), colors.plot, colors);
  }
  context.restore();
}

/** @type {(context: Context, view: View, way: Numbers, dash: number[], colors: import("./colors.js").Theme) => void} */
function trace(context, view, way, dash, colors) {
  for (const [color, width, dashes] of /** @type {[string, number, number[]][]} */ ([
    [colors.halo, 4.5, []],
    [colors.path, 2, dash],
  ])) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.setLineDash(dashes);
    context.beginPath();
    for (let i = 0; i < (way.shape[0] ?? 0); i++)
      context.lineTo(...toPixel(view, pointOf(way.data, i)));
    context.stroke();
  }
  context.setLineDash([]);
}

/** @type {(context: Context, view: View, at: Point, fill: string, colors: import("./colors.js").Theme) => void} */
function mark(context, view, at, fill, colors) {
  context.beginPath();
  context.arc(...toPixel(view, at), PUCK - 3, 0, 2 * Math.PI);
  context.fillStyle = fill;
  context.strokeStyle = colors.path;
  context.lineWidth = 2;
  context.fill();
  context.stroke();
}
