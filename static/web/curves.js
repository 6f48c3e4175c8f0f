/** Joint curves over time: generated solid, reference dashed, the band of the samples. */

import { classMark, ofSlot } from "./colors.js";
import { FONT, line } from "./plot.js";
import { clamp, formatted, ticks, toPixel } from "./scales.js";

/** @typedef {import("./plot.js").Context} Context */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./colors.js").Theme} Theme */
/**
 * @typedef {object} Curves all arrays hold `columns` joints a frame
 * @property {Float32Array} angles
 * @property {Float32Array | null} reference
 * @property {Float32Array | null} low
 * @property {Float32Array | null} high
 * @property {number} columns
 * @property {number | null} joint the one that is drawn; null: all
 * @property {number} frames of the time axis
 * @property {number} fps
 * @property {number} [slot] of the boards whose model it is
 * @property {Other[]} [others] of the other models on the boards, in slots of their own
 */
/** @typedef {Pick<Curves, "angles" | "low" | "high" | "columns"> & { joint: number, slot: number }} Other */

const LEAST_RANGE = 0.2; // radians; a joint that hardly moves is not blown up to full height

/** @type {(curves: Curves) => { bottom: number, top: number }} */
export function rangeOf({ angles, reference, low, high, columns, joint, others = [] }) {
  let least = Number.POSITIVE_INFINITY;
  let most = Number.NEGATIVE_INFINITY;
  /** @type {(values: Float32Array | null, first: number, every: number) => void} */
  const take = (values, first, every) => {
    for (let i = first; values && i < values.length; i += every) {
      if (values[i] < least) least = values[i];
      if (values[i] > most) most = values[i];
    }
  };
  for (const values of [angles, reference, ...(joint === null ? [] : [low, high])])
    take(values, joint ?? 0, joint === null ? 1 : columns);
  for (const one of others)
    for (const values of [one.angles, one.low, one.high]) take(values, one.joint, one.columns);
  if (!(least <= most)) return { bottom: -1, top: 1 };
  const pad = Math.max((LEAST_RANGE - (most - least)) / 2, 0.06 * (most - least));
  return { bottom: least - pad, top: most + pad };
}

/** @type {(context: Context, view: View, values: Float32Array, columns: number, joint: number) => void} */
function trace(context, view, values, columns, joint) {
  context.beginPath();
  for (let t = 0; t * columns + joint < values.length; t++) {
    context.lineTo(...toPixel(view, [t, values[t * columns + joint]]));
  }
  context.stroke();
}

/**
 * @param {Context} context
 * @param {View} view frames along the first axis, radians along the second
 * @param {Curves} curves
 * @param {Theme} colors
 * @param {number | null} observed share of the axis where the observed part ends
 * @param {number} frame of the cursor
 */
export function drawCurves(context, view, curves, colors, observed, frame) {
  const { box } = view;
  context.fillStyle = colors.plot;
  context.fillRect(box.left, box.top, box.width, box.height);
  if (observed !== null) {
    context.fillStyle = colors.observed;
    context.fillRect(box.left, box.top, observed * box.width, box.height);
  }
  drawSeconds(context, view, curves, colors);
  context.save();
  context.beginPath();
  context.rect(box.left, box.top, box.width, box.height);
  context.clip();
  context.lineJoin = "round";
  const joints =
    curves.joint === null ? Array.from({ length: curves.columns }, (_, j) => j) : [curves.joint];
  const all = curves.joint === null;
  const mine = ofSlot(colors, curves.slot ?? 0);
  for (const other of curves.others ?? []) drawOther(context, view, other, colors);
  if (!all) drawBand(context, view, curves, mine.band);
  for (const joint of joints) {
    const color = all ? classMark(joint).color : mine.curve;
    context.globalAlpha = all ? 0.75 : 1;
    if (curves.reference) {
      context.setLineDash([5, 4]);
      context.lineWidth = all ? 1 : 1.5;
      context.strokeStyle = all ? color : colors.target;
      trace(context, view, curves.reference, curves.columns, joint);
      context.setLineDash([]);
    }
    context.lineWidth = all ? 1.2 : 2;
    context.strokeStyle = color;
    trace(context, view, curves.angles, curves.columns, joint);
  }
  context.restore();
  context.strokeStyle = colors.grid;
  context.lineWidth = 1;
  context.strokeRect(box.left + 0.5, box.top + 0.5, box.width - 1, box.height - 1);
  if (observed !== null) drawHandle(context, view, colors, observed);
  drawCursor(context, view, colors, frame);
}

/** @type {(context: Context, view: View, other: Other, colors: Theme) => void} */
function drawOther(context, view, other, colors) {
  const { curve, band } = ofSlot(colors, other.slot);
  drawBand(context, view, other, band);
  context.lineWidth = 2;
  context.strokeStyle = curve;
  trace(context, view, other.angles, other.columns, other.joint);
}

/** @type {(context: Context, view: View, curves: Pick<Curves, "low" | "high" | "columns" | "joint">, band: string) => void} */
function drawBand(context, view, { low, high, columns, joint }, band) {
  if (!low || !high || joint === null) return;
  const frames = Math.floor(low.length / columns);
  context.beginPath();
  for (let t = 0; t < frames; t++) context.lineTo(...toPixel(view, [t, high[t * columns + joint]]));
  for (let t = frames - 1; t >= 0; t--)
    context.lineTo(...toPixel(view, [t, low[t * columns + joint]]));
  context.closePath();
  context.fillStyle = band;
  context.fill();
}

/** @type {(context: Context, view: View, curves: Curves, colors: Theme) => void} */
function drawSeconds(context, view, { frames, fps, joint }, colors) {
  const { box, extent } = view;
  context.font = FONT;
  context.lineWidth = 1;
  context.fillStyle = colors.quiet;
  context.textBaseline = "top";
  context.textAlign = "center";
  const seconds = ticks(0, (frames - 1) / fps, box.width / 70);
  for (const second of seconds) {
    const x = Math.round(toPixel(view, [second * fps, 0])[0]) + 0.5;
    line(context, colors.grid, x, box.top, x, box.top + box.height);
    const text = `${formatted(second, seconds[1] < 1 ? 1 : 0)} s`;
    const half = context.measureText(text).width / 2;
    const at = clamp(x, half, 2 * box.left + box.width - half);
    context.fillText(text, at, box.top + box.height + 3);
  }
  if (joint === null || extent.bottom > 0 || extent.top < 0) return;
  const zero = Math.round(toPixel(view, [0, 0])[1]) + 0.5;
  line(context, colors.zero, box.left, zero, box.left + box.width, zero);
}

/** @type {(context: Context, view: View, colors: Theme, observed: number) => void} */
function drawHandle(context, { box }, colors, observed) {
  const x = box.left + observed * box.width;
  context.lineWidth = 2;
  line(context, colors.curve, x, box.top, x, box.top + box.height);
  context.beginPath();
  context.roundRect(x - 4, box.top + box.height / 2 - 11, 8, 22, 4);
  context.fillStyle = colors.curve;
  context.fill();
}

/** @type {(context: Context, view: View, colors: Theme, frame: number) => void} */
function drawCursor(context, view, colors, frame) {
  const { box } = view;
  const [x] = toPixel(view, [frame, 0]);
  context.lineWidth = 1.5;
  line(context, colors.ink, x, box.top - 2, x, box.top + box.height);
  context.beginPath();
  context.arc(x, box.top, 4.5, 0, 2 * Math.PI);
  context.fillStyle = colors.puck;
  context.fill();
  context.stroke();
}
