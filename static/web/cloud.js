/** The belief over a codebook, on the map: many faint points, and rings round what it is torn between. */

import { FONT, haloed } from "./plot.js";
import { pointOf, toPixel } from "./scales.js";

/** @typedef {import("./messages.js").CloudShown} CloudShown */
/** @typedef {import("./plot.js").Context} Context */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./colors.js").Theme} Theme */

const DOT = 4; // pixels
const RING = 13;
const UNSEEN = 12; // of 255: fainter points are not drawn

/** The row of the last kept frame that has come by now. @type {(cloud: CloudShown, frame: number) => number} */
export function rowAt({ frames }, frame) {
  let row = 0;
  while (row + 1 < frames.data.length && frames.data[row + 1] <= frame) row++;
  return row;
}

/** Of an empty cloud nothing is drawn. @type {(cloud: CloudShown | null) => CloudShown | null} */
export const thereIn = (cloud) => (cloud?.places.shape[0] ? cloud : null);

/** @type {(context: Context, view: View, cloud: CloudShown, row: number, colors: Theme) => void} */
export function drawCloud(context, view, cloud, row, colors) {
  const count = cloud.places.shape[0] ?? 0;
  const weights = cloud.weights.data.subarray(row * count, (row + 1) * count);
  context.fillStyle = colors.cloud;
  for (let i = 0; i < count; i++) {
    if (weights[i] < UNSEEN) continue;
    const [x, y] = toPixel(view, pointOf(cloud.places.data, i));
    context.globalAlpha = 0.55 * (weights[i] / 255);
    context.fillRect(x - DOT / 2, y - DOT / 2, DOT, DOT);
  }
  context.globalAlpha = 1;
  if (row + 1 === cloud.frames.data.length && cloud.mass.data.length > 1)
    drawModes(context, view, cloud, colors);
}

/** What remains at the end, each with its share of the belief. @type {(context: Context, view: View, cloud: CloudShown, colors: Theme) => void} */
function drawModes(context, view, { modes, mass }, colors) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.lineWidth = 2;
  mass.data.forEach((share, k) => {
    const [x, y] = toPixel(view, pointOf(modes.data, k));
    context.strokeStyle = colors.cloud;
    context.beginPath();
    context.arc(x, y, RING, 0, 2 * Math.PI);
    context.stroke();
    haloed(context, percent(share), x + RING, y - RING / 2, colors, colors.cloud);
  });
}

/** @type {(share: number) => string} */
const percent = (share) => `${Math.round(100 * share)} %`;

/** @type {(cloud: CloudShown, row: number) => string} */
export function wordsOnCloud({ entropy, frames, entries, mass, near }, row) {
  const wide = Math.max(1, Math.round(2 ** (entropy.data[row] ?? 0)));
  const torn = near.map((name, k) => `${percent(mass.data[k] ?? 0)} near ${name}`).join(", ");
  return `Belief after frame ${frames.data[row] ?? 0}: spread over ${wide} of ${entries} motions; at the end ${torn}`;
}
