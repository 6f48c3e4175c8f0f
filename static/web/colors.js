/**
 * Colours that survive colour blindness, a projector and the dark.
 * Classes: the palette of Okabe and Ito, and another shape where its colours run out. Correlation:
 * ColorBrewer's RdBu as in the paper's Fig. 4, blue high, red low.
 */

import { clamp } from "./scales.js";

/** @typedef {{ color: string, shape: Shape }} Mark */
/** @typedef {"circle" | "diamond" | "triangle" | "square" | "pentagon"} Shape */

const OKABE_ITO = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9", "#cc79a7", "#f0e442"];
/** @type {Shape[]} */
const SHAPES = ["circle", "diamond", "triangle", "square", "pentagon"];

const RD_BU = "67001f b2182b d6604d f4a582 fddbc7 f7f7f7 d1e5f0 92c5de 4393c3 2166ac 053061";
const BR_BG = "543005 8c510a bf812d d0a75c d0bd8e bcbdb8 93c4bb 5cb0a3 35978f 01665e 003c30";
const VIRIDIS = "eed81f b5de2b 6ece58 35b779 1f9e89 26828e 31688e 3e4989 482878 440154";
const STEPS = 255; // odd: 0 on a scale from -1 to 1 has an entry of its own

/** Bytes r, g, b of `STEPS` colours, evenly from low to high. @type {(anchors: string) => Uint8Array} */
function table(anchors) {
  const colors = anchors.split(" ").map((hex) => Number.parseInt(hex, 16));
  const result = new Uint8Array(3 * STEPS);
  for (let i = 0; i < STEPS; i++) {
    const at = (i / (STEPS - 1)) * (colors.length - 1);
    const low = Math.min(Math.floor(at), colors.length - 2);
    for (let c = 0; c < 3; c++) {
      const shift = 16 - 8 * c;
      const from = (colors[low] >> shift) & 255;
      const to = (colors[low + 1] >> shift) & 255;
      result[3 * i + c] = Math.round(from + (to - from) * (at - low));
    }
  }
  return result;
}

const TABLES = { correlation: table(RD_BU), valence: table(BR_BG), arousal: table(VIRIDIS) };
/** @typedef {keyof typeof TABLES} Scale */
const UNKNOWN = [150, 156, 164];

/** Colour of a share of the way from low to high; grey for no number. @type {(scale: Scale, share: number) => number[]} */
export function rgb(scale, share) {
  if (Number.isNaN(share)) return UNKNOWN;
  const i = 3 * Math.round(clamp(share, 0, 1) * (STEPS - 1));
  return [...TABLES[scale].subarray(i, i + 3)];
}

/** @type {(scale: Scale, share: number) => string} */
export const css = (scale, share) => `rgb(${rgb(scale, share).join(" ")})`;

/** A horizontal scale as a CSS gradient. @type {(scale: Scale, direction?: string) => string} */
export function gradient(scale, direction = "to right") {
  const stops = Array.from({ length: 11 }, (_, i) => css(scale, i / 10));
  return `linear-gradient(${direction}, ${stops.join(", ")})`;
}

/** How points of the k-th class look. @type {(k: number) => Mark} */
export const classMark = (k) => ({
  color: OKABE_ITO[k % OKABE_ITO.length],
  shape: SHAPES[Math.floor(k / OKABE_ITO.length) % SHAPES.length],
});

/**
 * What the canvases draw with, for a light and a dark page.
 * @typedef {typeof LIGHT} Theme
 */
const LIGHT = {
  plot: "#ffffff",
  grid: "#e9ecf0",
  zero: "#cfd5dc",
  axis: "#8b95a1",
  text: "#2b3440",
  quiet: "#66707c",
  halo: "rgb(255 255 255 / 0.85)",
  outline: "rgb(30 40 52 / 0.55)",
  puck: "#ffb000",
  ink: "#16202c",
  path: "#b3003c",
  circle: "#b3003c",
  sample: "#0b6b4f",
  cloud: "#6a3d9a",
  band: "rgb(0 114 178 / 0.18)",
  curve: "#0072b2",
  second: "#a0527d",
  secondBand: "rgb(204 121 167 / 0.24)",
  target: "#8a4b00",
  warning: "#a84300",
  observed: "rgb(0 114 178 / 0.09)",
};
/** @type {Theme} */
const DARK = {
  plot: "#1a1d21",
  grid: "#2a2f36",
  zero: "#434b55",
  axis: "#7d8894",
  text: "#dfe4ea",
  quiet: "#9aa4af",
  halo: "rgb(20 23 27 / 0.85)",
  outline: "rgb(240 244 250 / 0.6)",
  puck: "#ffb000",
  ink: "#f4f7fa",
  path: "#ff6b93",
  circle: "#ff6b93",
  sample: "#43c59e",
  cloud: "#b79be0",
  band: "rgb(86 180 233 / 0.22)",
  curve: "#56b4e9",
  second: "#e39bc4",
  secondBand: "rgb(227 155 196 / 0.24)",
  target: "#e6a54a",
  warning: "#ffa05c",
  observed: "rgb(86 180 233 / 0.13)",
};

/** On the landscape's own colours, light or dark the page. */
export const ON_LANDSCAPE = {
  path: "#c2003f",
  circle: "#ffffff",
  sample: "#ffffff",
  plot: "#ffffff",
  halo: "rgb(255 255 255 / 0.9)",
};

/** What the curves of one of two models are drawn with. @type {(colors: Theme, slot: number) => { curve: string, band: string }} */
export const ofSlot = (colors, slot) =>
  slot
    ? { curve: colors.second, band: colors.secondBand }
    : { curve: colors.curve, band: colors.band };

/** @type {(dark: boolean) => Theme} */
export const theme = (dark) => (dark ? DARK : LIGHT);
