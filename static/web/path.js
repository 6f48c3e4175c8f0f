/**
 * A recognition's way over a board: mu joined by a line, sigma as circles, sampled PBs as crosses. Where
 * mu jumped to a sample (an early update) there is a square; elsewhere a gradient moved it.
 */

import { line } from "./plot.js";
import { pointOf, toPixel } from "./scales.js";

/** @typedef {import("./plot.js").Context} Context */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./messages.js").Numbers} Numbers */

const MOST_CIRCLES = 48; // of many iterates only some, so that one sees through them
const JUMP = 7; // pixels
const MOST_RADIUS = 400; // pixels; what is larger covers the board anyway

/**
 * @param {Context} context
 * @param {View} view
 * @param {{ mu: Numbers, radii: Numbers, samples: Numbers | null, shown: number, others?: Numbers | null,
 *   early?: import("./messages.js").Numbers<Uint8Array> | null }} path
 * @param {import("./colors.js").Theme} colors
 */
export function drawPath(context, view, { mu, radii, samples, shown, others, early }, colors) {
  const count = mu.shape[0] ?? 0;
  if (count === 0) return;
  const last = Math.min(Math.max(shown, 0), count - 1);
  const unit = view.box.width / (view.extent.right - view.extent.left);
  const at = (/** @type {number} */ i) => toPixel(view, pointOf(mu.data, i));
  context.save();
  const every = Math.max(1, Math.ceil(last / MOST_CIRCLES));
  context.strokeStyle = colors.circle;
  context.lineWidth = 1;
  for (let i = last % every; i <= last; i += every) {
    const [x, y] = at(i);
    context.globalAlpha = i === last ? 0.9 : 0.15 + 0.3 * (i / Math.max(last, 1));
    context.beginPath();
    context.arc(x, y, Math.min(Math.abs(radii.data[i]) * unit, MOST_RADIUS), 0, 2 * Math.PI);
    context.stroke();
  }
  if (others) drawOthers(context, view, others, last, colors);
  if (samples) drawSamples(context, view, samples, colors.sample);
  context.globalAlpha = 1;
  drawWay(context, at, last, colors);
  if (early) {
    context.fillStyle = colors.path;
    for (let i = 0; i < last; i++) {
      if (!early.data[i]) continue;
      const [x, y] = at(i + 1); // where it jumped to
      context.fillRect(x - JUMP / 2, y - JUMP / 2, JUMP, JUMP);
    }
  }
  context.restore();
}

/** The ways of the other trials, thin. @type {(context: Context, view: View, others: Numbers, last: number, colors: import("./colors.js").Theme) => void} */
function drawOthers(context, view, others, last, colors) {
  const [count = 0, steps = 0] = others.shape;
  context.globalAlpha = 0.45;
  context.lineWidth = 1;
  context.strokeStyle = colors.path;
  for (let k = 0; k < count; k++) {
    context.beginPath();
    for (let i = 0; i <= Math.min(last, steps - 1); i++)
      context.lineTo(...toPixel(view, pointOf(others.data, k * steps + i)));
    context.stroke();
  }
}

/** @type {(context: Context, view: View, samples: Numbers, color: string) => void} */
function drawSamples(context, view, samples, color) {
  context.globalAlpha = 0.85;
  context.lineWidth = 1.4;
  for (let i = 0; i + 1 < samples.data.length; i += 2) {
    const [x, y] = toPixel(view, [samples.data[i], samples.data[i + 1]]);
    line(context, color, x - 3, y - 3, x + 3, y + 3);
    line(context, color, x - 3, y + 3, x + 3, y - 3);
  }
}

/** @type {(context: Context, at: (i: number) => [number, number], last: number, colors: import("./colors.js").Theme) => void} */
function drawWay(context, at, last, colors) {
  const trace = () => {
    context.beginPath();
    for (let i = 0; i <= last; i++) context.lineTo(...at(i));
    context.stroke();
  };
  context.lineJoin = "round";
  context.strokeStyle = colors.halo;
  context.lineWidth = 4;
  trace();
  context.strokeStyle = colors.path;
  context.lineWidth = 2;
  trace();
  for (const [i, fill] of /** @type {[number, string][]} */ ([
    [0, colors.plot],
    [last, colors.path],
  ])) {
    context.beginPath();
    context.arc(...at(i), 4, 0, 2 * Math.PI);
    context.fillStyle = fill;
    context.fill();
    context.stroke();
  }
}
