/** The correlation landscape: numbers from the server, coloured here, with the puck in its window. */

import { Board, nameOf } from "./board.js";
import { gradient, ON_LANDSCAPE, rgb } from "./colors.js";
import { cellAt, contour, interpolated, maximum } from "./grid.js";
import { wordsOnPath } from "./map.js";
import { element, say } from "./page.js";
import { drawPath } from "./path.js";
import { haloed, line } from "./plot.js";
import { clamp, formatted, nearest, pointOf, toData, toPixel } from "./scales.js";

/** @typedef {import("./board.js").Ask} Ask */
/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./messages.js").LandscapeShown} LandscapeShown */
/** @typedef {import("./messages.js").MapShown} MapShown */
/** @typedef {import("./messages.js").PathShown} PathShown */
/** @typedef {import("./messages.js").PuckShown} PuckShown */
/** @typedef {import("./moves.js").Move} Move */
/** @typedef {import("./scales.js").Point} Point */
/** @typedef {import("./scales.js").View} View */

const NEAR_MAXIMUM = 0.9; // of the maximum, where the line is drawn and what `area` counts
const SMOOTH = 96; // pixels along either side of the picture of a coarse landscape
const REACH = 10; // pixels from a learned point that the pointer still means it
const LOWEST = -1.05; // of the axis of a landscape of one dimension

export class LandscapeBoard extends Board {
  /** @param {Ask} ask @param {() => void} looked @param {number} [slot] */
  constructor(ask, looked, slot = 0) {
    super(ask, looked, {
      title: "Correlation landscape",
      name: nameOf("landscape", slot),
      label: "Correlation landscape. Drag or use the arrow keys to move the puck.",
    });
    /** @type {LandscapeShown | null} */ this.shown = null;
    /** @type {MapShown | null} */ this.motions = null;
    /** @type {PathShown | null} */ this.path = null;
    /** @type {Grid} */ this.grid = { values: [], x: [], y: [] };
    /** @type {number[]} */ this.line = []; // where the correlation is 0.9 of its maximum
    this.picture = document.createElement("canvas");
    this.numbers = element("dl", { class: "rb-numbers" });
    this.bar = element("div", { class: "rb-key" }, [
      element("i"),
      element("span", { text: "1" }),
      element("span", { text: "0" }),
      element("span", { text: "−1" }),
    ]);
    const bar = /** @type {HTMLElement} */ (this.bar.firstElementChild);
    bar.style.background = gradient("correlation", "to top");
    this.parts.legend.append(this.bar, this.numbers);
  }

  // --- what the server shows ---
  /** @param {LandscapeShown} shown */
  show(shown) {
    this.shown = shown;
    const { correlation, x, y, extent } = shown;
    const [left = 0, right = 1, bottom = 0, top = 1] = extent.data;
    const flat = y.data.length === 1;
    const home = flat
      ? { left, right, bottom: LOWEST, top: -LOWEST }
      : { left, right, bottom, top };
    const corner = [left, bottom].map((value) => value.toFixed(3));
    this.setHome(home, `${shown.model} ${shown.axis_labels} ${corner}`);
    this.grid = { values: correlation.data, x: x.data, y: y.data };
    this.line = flat ? [] : contour(this.grid, this.level);
    if (!flat) this.colour();
    if (this.puck) this.setPuck(this.riding(this.puck));
    this.showNumbers(shown);
    say(this.parts.heading, shown.target || "Correlation landscape"); // the tab above says what it is
    this.surface.request();
    this.tell();
  }

  get level() {
    return NEAR_MAXIMUM * maximum(this.grid.values);
  }

  /** The names of the learned points come with the map. @param {MapShown} map */
  showMap(map) {
    this.motions = map;
  }

  /** @param {PuckShown} state */
  showPuck(state) {
    if (!this.moves.accepts(state.heard)) return;
    const at = state.on_landscape?.data;
    this.setPuck(at ? this.riding(pointOf(at)) : null);
    this.surface.request();
    this.tell();
  }

  /** @param {PathShown} path */
  showPath(path) {
    this.path = path;
    this.surface.request();
    this.tell();
  }

  /** A complete landscape shows its cells; a coarse one what is likely between them. */
  colour() {
    const { grid, picture } = this;
    const smooth = !this.shown?.complete;
    const columns = smooth ? SMOOTH : grid.x.length;
    const rows = smooth ? SMOOTH : grid.y.length;
    const image = new ImageData(columns, rows);
    const { left, right, bottom, top } = this.home ?? { left: 0, right: 1, bottom: 0, top: 1 };
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) {
        const x = left + ((column + 0.5) / columns) * (right - left);
        const y = bottom + ((row + 0.5) / rows) * (top - bottom);
        const value = smooth
          ? interpolated(grid, x, y)
          : (grid.values[row * columns + column] ?? Number.NaN);
        const [r = 0, g = 0, b = 0] = rgb("correlation", (value + 1) / 2);
        image.data.set([r, g, b, 255], 4 * ((rows - 1 - row) * columns + column));
      }
    }
    picture.width = columns;
    picture.height = rows;
    picture.getContext("2d")?.putImageData(image, 0, 0);
  }

  /** @param {LandscapeShown} shown */
  showNumbers({ mean, area, roughness, complete, window: words }) {
    /** @type {[string, string, string][]} */
    const rows = [
      ["mean", formatted(mean), "mean correlation"],
      ["area", `${Math.round(100 * area)} %`, "cells above 0.9 of the maximum"],
      ["rough", formatted(roughness, 3), "mean difference of neighbouring cells"],
    ];
    this.numbers.replaceChildren(
      ...rows.flatMap(([name, value, title]) => [
        element("dt", { text: name, title }),
        element("dd", { text: value }),
      ]),
      element("dd", {
        class: "rb-stage",
        "data-complete": String(complete),
        text: complete ? "complete" : "coarse …",
      }),
      element("dd", { class: "rb-note", text: words }),
    );
  }

  // --- a board's own answers ---
  get flat() {
    return this.grid.y.length === 1;
  }

  get bare() {
    return false;
  }

  /** Equal units along both axes, in as large a part of the box as that leaves. @type {Board["shaped"]} */
  shaped(box) {
    if (this.flat || !this.home) return box;
    const { left, right, bottom, top } = this.home;
    const unit = Math.min(box.width / (right - left), box.height / (top - bottom));
    return { ...box, width: unit * (right - left), height: unit * (top - bottom) };
  }

  labels() {
    return this.flat
      ? [this.shown?.axis_labels[0] ?? "", "correlation"]
      : (this.shown?.axis_labels ?? []);
  }

  /** @param {Point} at */
  pointAt(at) {
    const { view, shown } = this;
    return view && shown?.learned ? nearest(view, shown.learned.data, at, REACH) : -1;
  }

  /** @param {number} point */
  select(point) {
    const index = this.shown?.learned_index?.data[point];
    if (index !== undefined)
      this.ask({ type: "SelectMotion", model: this.shown?.model ?? 0, index });
  }

  /** @param {Point} at */
  describe(at) {
    const { view } = this;
    if (!view || !this.grid.values.length) return "";
    const { left, top, width, height } = view.box;
    if (at[0] < left || at[1] < top || at[0] > left + width || at[1] > top + height) return "";
    const words = this.wordsOn(toData(view, at));
    const learned = this.shown?.learned_index?.data[this.pointAt(at)];
    const name = learned === undefined ? "" : this.motions?.names[learned];
    return name ? `${name} · ${words}` : words;
  }

  /** The cell at a point. @param {Point} point */
  wordsOn([x, y]) {
    const { grid } = this;
    const [row, column] = cellAt(grid, x, y);
    const value = this.shown?.complete
      ? (grid.values[row * grid.x.length + column] ?? Number.NaN)
      : interpolated(grid, x, y);
    const at = [grid.x[column], ...(this.flat ? [] : [grid.y[row]])];
    return `${at.map((v) => formatted(v)).join(", ")} · r ${this.shown?.complete ? "=" : "≈"} ${formatted(value)}`;
  }

  /** @param {Move} move @returns {import("./messages.js").Asked} */
  asked({ to, gesture, number, done }) {
    const { model = 0, axis_labels: axes = [] } = this.shown ?? {};
    return { type: "MoveOnLandscape", model, axes, to, gesture, number, done };
  }

  // --- drawing ---
  /** @param {CanvasRenderingContext2D} context @param {View} view */
  content(context, view) {
    const { shown, path } = this;
    if (!shown || !this.home) return;
    if (this.flat) {
      this.drawCurve(context, view);
      return;
    }
    const [left, top] = toPixel(view, [this.home.left, this.home.top]);
    const [right, bottom] = toPixel(view, [this.home.right, this.home.bottom]);
    context.imageSmoothingEnabled = !shown.complete;
    context.drawImage(this.picture, left, top, right - left, bottom - top);
    this.drawLine(context, view);
    this.drawLearned(context, view, shown);
    if (path?.on_landscape) {
      const { on_landscape: mu, samples_on_landscape: samples, radii, shown: last } = path;
      drawPath(
        context,
        view,
        { mu, samples, radii, shown: last },
        { ...this.theme, ...ON_LANDSCAPE },
      );
    }
  }

  /** @param {CanvasRenderingContext2D} context @param {View} view */
  drawLine(context, view) {
    const trace = () => {
      context.beginPath();
      for (let i = 0; i + 3 < this.line.length; i += 4) {
        context.moveTo(...toPixel(view, [this.line[i], this.line[i + 1]]));
        context.lineTo(...toPixel(view, [this.line[i + 2], this.line[i + 3]]));
      }
      context.stroke();
    };
    context.lineCap = "round";
    context.strokeStyle = "rgb(255 255 255 / 0.8)";
    context.lineWidth = 3;
    trace();
    context.strokeStyle = "#1c2733";
    context.lineWidth = 1.3;
    trace();
    context.lineCap = "butt";
  }

  /** @param {CanvasRenderingContext2D} context @param {View} view @param {LandscapeShown} shown */
  drawLearned(context, view, { learned, learned_index: indices }) {
    if (!learned) return;
    context.textAlign = "left";
    context.textBaseline = "middle";
    for (let i = 0; 2 * i + 1 < learned.data.length; i++) {
      const [x, y] = toPixel(view, pointOf(learned.data, i));
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fillStyle = "#ffffff";
      context.fill();
      context.lineWidth = 1.5;
      context.strokeStyle = "#1c2733";
      context.stroke();
      const index = indices?.data[i] ?? -1;
      if (index !== this.motions?.selected) continue;
      context.beginPath();
      context.arc(x, y, 8, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  /** One dimension: correlation upwards. @param {CanvasRenderingContext2D} context @param {View} view */
  drawCurve(context, view) {
    const { grid } = this;
    const { box } = view;
    const level = toPixel(view, [0, this.level])[1];
    context.setLineDash([4, 3]);
    context.lineWidth = 1;
    line(context, this.theme.quiet, box.left, level, box.left + box.width, level);
    const zero = toPixel(view, [0, 0])[1];
    context.setLineDash([]);
    line(context, this.theme.zero, box.left, zero, box.left + box.width, zero);
    context.beginPath();
    for (let i = 0; i < grid.x.length; i++) {
      context.lineTo(...toPixel(view, [grid.x[i], grid.values[i]]));
    }
    context.strokeStyle = this.theme.curve;
    context.lineWidth = 2.2;
    context.stroke();
    context.textAlign = "left";
    context.textBaseline = "bottom";
    haloed(context, "0.9 of the maximum", box.left + 6, level - 2, this.theme, this.theme.quiet);
  }

  /** In one dimension the puck rides on the curve. @param {Point} point @returns {Point} */
  riding([x, y]) {
    return [x, this.flat ? clamp(interpolated(this.grid, x, 0), -1, 1) : y];
  }

  /** @param {Point} to @returns {Point} */
  allowed(to) {
    return this.riding(super.allowed(to));
  }

  // --- words ---
  words() {
    const { shown, puck } = this;
    if (!shown) return {};
    const [x = "", y = ""] = shown.axis_labels;
    const { left, right, bottom, top } = this.home ?? { left: 0, right: 0, bottom: 0, top: 0 };
    /** @type {Record<string, string>} */
    const words = {
      landscape: `Landscape ${this.grid.x.length}×${this.grid.y.length} ${shown.complete ? "complete" : "coarse"}`,
      numbers: `Mean ${formatted(shown.mean)}, area ${formatted(shown.area)}, roughness ${formatted(shown.roughness, 3)}`,
      window: `${shown.window}: ${x} from ${formatted(left)} to ${formatted(right)}${this.flat ? "" : `, ${y} from ${formatted(bottom)} to ${formatted(top)}`}`,
      target: `Compared with ${shown.target}`,
    };
    if (puck) {
      const drawn = this.flat ? [puck[0]] : puck;
      const at = drawn.map((value, i) => `${shown.axis_labels[i]} ${formatted(value)}`).join(", ");
      const [row, column] = cellAt(this.grid, puck[0], puck[1]);
      const value = this.grid.values[row * this.grid.x.length + column] ?? Number.NaN;
      words.puck = `Puck at ${at}, correlation ${formatted(value)}`;
      say(this.parts.readout, `r = ${formatted(value)}`);
    }
    if (this.path?.on_landscape) {
      words.path = wordsOnPath(this.path, this.path.on_landscape.data);
    }
    return words;
  }
}
