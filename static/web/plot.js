/** What is drawn on both boards alike: axes, lines, the puck. */

import { clamp, digitsOf, formatted, ticks, toPixel } from "./scales.js";

/** @typedef {CanvasRenderingContext2D} Context */
/** @typedef {import("./scales.js").Box} Box */
/** @typedef {import("./scales.js").Point} Point */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./colors.js").Theme} Theme */

export const FONT = '500 11px Inter, "Inter Variable", system-ui, sans-serif';
export const PUCK = 9; // radius in pixels
const PUCK_INK = "#1c2733"; // on the puck's own colour, light or dark the page

/** @type {(context: Context, color: string, x0: number, y0: number, x1: number, y1: number) => void} */
export function line(context, color, x0, y0, x1, y1) {
  context.strokeStyle = color;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

/**
 * Grid, ticks and names of the axes; `flat` leaves the second one out.
 * @type {(context: Context, view: View, colors: Theme, names: string[], flat: boolean) => void}
 */
export function drawAxes(context, view, colors, names, flat) {
  const { extent, box } = view;
  const bottom = box.top + box.height;
  context.font = FONT;
  context.fillStyle = colors.plot;
  context.fillRect(box.left, box.top, box.width, box.height);
  context.lineWidth = 1;
  context.fillStyle = colors.quiet;
  context.textAlign = "center";
  context.textBaseline = "top";
  const xs = ticks(extent.left, extent.right, box.width / 60);
  for (const x of xs) {
    const px = Math.round(toPixel(view, [x, 0])[0]) + 0.5;
    line(context, x === 0 ? colors.zero : colors.grid, px, box.top, px, bottom);
    context.fillText(formatted(x, digitsOf(xs)), px, bottom + 4);
  }
  context.textAlign = "right";
  context.textBaseline = "middle";
  const ys = flat ? [] : ticks(extent.bottom, extent.top, box.height / 44);
  for (const y of ys) {
    const py = Math.round(toPixel(view, [0, y])[1]) + 0.5;
    line(context, y === 0 ? colors.zero : colors.grid, box.left, py, box.left + box.width, py);
    context.fillText(formatted(y, digitsOf(ys)), box.left - 5, py);
  }
  drawNames(context, box, colors, names, flat);
}

/** @type {(context: Context, box: Box, colors: Theme, names: string[], flat: boolean) => void} */
function drawNames(context, box, colors, [x, y], flat) {
  context.fillStyle = colors.text;
  context.textAlign = "center";
  context.textBaseline = "top";
  context.fillText(x ?? "", box.left + box.width / 2, box.top + box.height + 17);
  if (!y || flat) return;
  context.save();
  context.translate(1, box.top + box.height / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(y, 0, 0);
  context.restore();
}

/**
 * The puck; hollow at the edge where it lies outside.
 * @type {(context: Context, at: Point, box: Box, colors: Theme, warned: boolean) => void}
 */
export function drawPuck(context, [x, y], box, colors, warned) {
  const px = clamp(x, box.left, box.left + box.width);
  const py = clamp(y, box.top, box.top + box.height);
  const outside = Math.hypot(px - x, py - y) > 1;
  context.save();
  context.beginPath();
  context.arc(px, py, PUCK, 0, 2 * Math.PI);
  context.shadowColor = "rgb(0 0 0 / 0.35)";
  context.shadowBlur = 4;
  context.shadowOffsetY = 1;
  context.fillStyle = outside ? colors.plot : colors.puck;
  context.fill();
  context.shadowColor = "transparent";
  context.lineWidth = 2.5;
  context.strokeStyle = warned ? colors.warning : outside ? colors.puck : PUCK_INK;
  context.stroke();
  context.beginPath();
  context.arc(px, py, 2, 0, 2 * Math.PI);
  context.fillStyle = outside ? colors.puck : PUCK_INK;
  context.fill();
  context.restore();
}

/** Text that stays legible on whatever lies behind it. @type {(context: Context, text: string, x: number, y: number, colors: Theme, color?: string) => void} */
export function haloed(context, text, x, y, colors, color = colors.text) {
  context.strokeStyle = colors.halo;
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeText(text, x, y);
  context.fillStyle = color;
  context.fillText(text, x, y);
}

/** @type {(context: Context, shape: import("./colors.js").Shape, x: number, y: number, radius: number) => void} */
export function tracePath(context, shape, x, y, radius) {
  context.beginPath();
  if (shape === "circle") {
    context.arc(x, y, radius, 0, 2 * Math.PI);
    return;
  }
  const sides = { diamond: 4, square: 4, triangle: 3, pentagon: 5 }[shape];
  const turn = shape === "square" ? Math.PI / 4 : 0;
  const size = radius * (shape === "triangle" ? 1.25 : 1.13);
  for (let i = 0; i < sides; i++) {
    const angle = turn - Math.PI / 2 + (i / sides) * 2 * Math.PI;
    context.lineTo(x + size * Math.cos(angle), y + size * Math.sin(angle));
  }
  context.closePath();
}
