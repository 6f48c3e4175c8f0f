/** The PB map: the learned mu on two components, what is selected, sigma as an ellipse, the puck. */

import { Board, nameOf } from "./board.js";
import { drawCloud, rowAt, thereIn, wordsOnCloud } from "./cloud.js";
import { classMark, css } from "./colors.js";
import { classLegend, scaleLegend } from "./legend.js";
import { element, say } from "./page.js";
import { drawPath } from "./path.js";
import { haloed, line } from "./plot.js";
import { drawAdded, drawEllipse, drawNames, drawPoints } from "./points.js";
import {
  clamp,
  ellipseOf,
  formatted,
  nearest,
  pointOf,
  toData,
  toPixel,
  withEqualUnits,
} from "./scales.js";
import { drawWays } from "./ways.js";

/** @typedef {import("./board.js").Ask} Ask */
/** @typedef {import("./colors.js").Mark} Mark */
/** @typedef {import("./messages.js").CloudShown} CloudShown */
/** @typedef {import("./messages.js").MapShown} MapShown */
/** @typedef {import("./messages.js").PathShown} PathShown */
/** @typedef {import("./messages.js").PuckShown} PuckShown */
/** @typedef {import("./messages.js").WaysShown} WaysShown */
/** @typedef {import("./moves.js").Move} Move */
/** @typedef {import("./scales.js").Point} Point */
/** @typedef {import("./scales.js").View} View */

const REACH = 12; // pixels from a point that the pointer still means it
const FARTHEST = 0.3; // opacity of the point that lies farthest from the slice
const UNLIT = 0.15; // opacity of what the legend's pointer is not on

export class MapBoard extends Board {
  /** @param {Ask} ask @param {() => void} looked @param {number} [slot] */
  constructor(ask, looked, slot = 0) {
    super(ask, looked, {
      title: "PB map",
      name: nameOf("map", slot),
      label: "Map of the latent space. Drag or use the arrow keys to move the puck.",
    });
    /** @type {MapShown | null} */ this.shown = null;
    /** @type {PuckShown | null} */ this.state = null;
    /** @type {PathShown | null} */ this.path = null;
    /** @type {CloudShown | null} */ this.cloud = null;
    /** @type {WaysShown | null} */ this.ways = null;
    this.cloudRow = 0; // of the belief, at the frame that is played
    this.frame = 0;
    /** @type {Mark[]} */ this.marks = [];
    this.listed = ""; // all points in words
    /** @type {string | null} */ this.lit = null; // the class that the legend's pointer is on
    /** @type {number[]} */ this.hidden = []; // the puck along the axes that are not drawn
    /** @type {{ at: Point, hidden: number[] } | null} */ this.grabbed = null;
    this.toggle = element("button", {
      class: "rb-chip",
      type: "button",
      "aria-pressed": "false",
      title: "Drag along the components that are not drawn (or hold Shift)",
    });
    this.toggle.addEventListener("click", () => this.setHidden(!this.movesHidden));
    this.parts.tools.prepend(this.toggle);
  }

  get movesHidden() {
    return this.toggle.getAttribute("aria-pressed") === "true";
  }

  /** @param {boolean} on */
  setHidden(on) {
    this.toggle.setAttribute("aria-pressed", String(on));
    this.surface.request();
  }

  // --- what the server shows ---
  /** @param {MapShown} shown */
  show(shown) {
    this.shown = shown;
    const [left = -1, right = 1, bottom = -1, top = 1] = shown.extent.data;
    this.setHome({ left, right, bottom, top }, `${shown.title} ${shown.axes}`);
    say(this.parts.heading, shown.title || "PB map"); // the tab above says what it is
    this.marks = this.looks(shown);
    const listed = shown.names.map((name, i) => {
      const at = pointOf(shown.points.data, i).map((value) => formatted(value));
      return `${name} (${at.join(", ")})`;
    });
    this.listed = `${listed.length} learned motions: ${listed.join("; ")}`;
    this.showLegend(shown);
    const names = shown.axis_labels.slice(shown.axes.length);
    this.toggle.hidden = names.length === 0;
    say(this.toggle, `⇅ ${names.join(", ")}`);
    this.surface.request();
    this.tell();
  }

  /** @param {PuckShown} state */
  showPuck(state) {
    this.state = state;
    if (this.moves.accepts(state.heard)) {
      this.puck = pointOf(state.on_map.data);
      this.hidden = [...state.hidden.data];
    }
    this.parts.mark.hidden = !this.warned;
    say(
      this.parts.mark,
      this.warned ? `extrapolating · ${formatted(state.extrapolation ?? 0, 1)} gaps away` : "",
    );
    this.surface.request();
    this.tell();
  }

  /** @param {PathShown} path */
  showPath(path) {
    this.path = path;
    this.surface.request();
    this.tell();
  }

  /** @param {WaysShown} ways */
  showWays(ways) {
    this.ways = ways.straight ? ways : null;
    this.surface.request();
    this.tell();
  }

  /** @param {CloudShown} cloud */
  showCloud(cloud) {
    this.cloud = cloud;
    this.cloudRow = rowAt(cloud, this.frame);
    this.surface.request();
    this.tell();
  }

  /** What was seen of the motion by this frame. @param {number} frame */
  atFrame(frame) {
    this.frame = frame;
    if (this.ways?.shares) this.surface.request();
    const row = this.cloud ? rowAt(this.cloud, frame) : 0;
    if (row === this.cloudRow) return;
    this.cloudRow = row;
    this.surface.request();
    this.tell();
  }

  /** @param {MapShown} shown @returns {Mark[]} */
  looks({ colouring, classes, values, names }) {
    if (colouring === "class") {
      const order = [...new Set(classes)].sort();
      return classes.map((name) => classMark(order.indexOf(name)));
    }
    return names.map((_, i) => ({
      color: css(colouring, values?.data[i] ?? Number.NaN),
      shape: "circle",
    }));
  }

  /** @param {MapShown} shown */
  showLegend({ colouring, classes }) {
    if (colouring === "class") {
      classLegend(this.parts.legend, classes, (name) => {
        this.lit = name;
        this.surface.request();
      });
    } else {
      const ends = colouring === "valence" ? ["negative", "positive"] : ["calm", "excited"];
      scaleLegend(this.parts.legend, colouring, ends[0] ?? "", ends[1] ?? "");
    }
  }

  // --- a board's own answers ---
  get flat() {
    return this.shown?.axes.length === 1;
  }

  get warned() {
    return (this.state?.extrapolation ?? 0) > 1;
  }

  /** @type {Board["fitted"]} */
  fitted(extent, box) {
    return this.flat ? extent : withEqualUnits(extent, box);
  }

  labels() {
    return this.shown?.axis_labels ?? [];
  }

  /** @param {Point} at */
  pointAt(at) {
    const { view, shown } = this;
    if (!view || !shown) return -1;
    const learned = nearest(view, shown.points.data, at, REACH);
    const added = learned < 0 ? nearest(view, shown.added.data, at, REACH) : -1;
    return added < 0 ? learned : shown.names.length + added;
  }

  /** @param {number} index */
  select(index) {
    const own = index - (this.shown?.names.length ?? 0);
    if (own < 0) this.ask({ type: "SelectMotion", model: this.shown?.model ?? 0, index });
    else this.ask({ type: "SelectAdded", index: this.shown?.added_index.data[own] ?? 0 });
  }

  /** The whole plot is free to the hand, wider than the learned points. @param {Point} to @returns {Point} */
  allowed([x, y]) {
    const extent = this.view?.extent;
    if (!extent) return [x, y];
    return [
      clamp(x, extent.left, extent.right),
      this.flat ? 0 : clamp(y, extent.bottom, extent.top),
    ];
  }

  /** @param {Point} at */
  describe(at) {
    const index = this.pointAt(at);
    return index < 0 ? "" : this.wordsOn(index);
  }

  /** @param {number} index */
  wordsOn(index) {
    const { shown, state } = this;
    if (!shown) return "";
    const own = index - shown.names.length;
    if (own >= 0) return `${shown.added_names[own]} · your point`;
    const value = shown.values?.data[index];
    const parts = [shown.names[index] ?? ""];
    if (shown.colouring === "class") parts.push(shown.classes[index] ?? "");
    else parts.push(value === undefined || Number.isNaN(value) ? "no rating" : formatted(value));
    const off = state?.off_plane?.data[index];
    if (off !== undefined) parts.push(`${formatted(off)} off this slice`);
    return parts.filter(Boolean).join(" · ");
  }

  /** @param {Move} move @returns {import("./messages.js").Asked} */
  asked({ to, axes, gesture, number, done }) {
    const drawn = this.shown?.axes ?? [];
    const model = this.shown?.model ?? 0;
    return {
      type: "MoveOnMap",
      model,
      axes: axes.length ? axes : drawn,
      to,
      gesture,
      number,
      done,
    };
  }

  // --- along what is not drawn ---
  /** @param {Point} at @param {MouseEvent} event @param {boolean} first */
  moveTo(at, event, first) {
    const { view } = this;
    const hidden = this.shown?.hidden_axes ?? [];
    if (first) {
      const along = hidden.length > 0 && (this.movesHidden || event.shiftKey);
      this.grabbed = along ? { at, hidden: [...this.hidden] } : null;
    }
    if (!this.grabbed || !view) {
      super.moveTo(at, event, first);
      return;
    }
    const from = toData(view, this.grabbed.at);
    const to = toData(view, at);
    this.putHidden(this.grabbed.hidden.map((value, i) => value + (to[i] ?? 0) - (from[i] ?? 0)));
  }

  /** @param {Point} way @param {boolean} shift */
  step(way, shift) {
    if (!this.view || !this.shown || !(shift || this.movesHidden)) {
      super.step(way, shift);
      return;
    }
    const { left, right } = this.view.extent;
    this.putHidden(this.hidden.map((value, i) => value + (way[i] * (right - left)) / 50));
  }

  /** @param {number[]} to */
  putHidden(to) {
    this.hidden = to;
    this.moves.put(to, this.shown?.hidden_axes ?? []);
    this.surface.request();
    this.tell();
  }

  // --- drawing ---
  /** @param {CanvasRenderingContext2D} context @param {View} view */
  content(context, view) {
    const { shown, path, puck } = this;
    if (!shown) return;
    if (puck && this.state?.covariance) {
      drawEllipse(context, view, puck, this.state.covariance.data, this.theme);
    }
    const points = {
      places: shown.points.data,
      names: shown.names,
      marks: this.marks,
      near: this.nearness(shown),
      selected: shown.selected,
      under: this.hovered ? this.pointAt(this.hovered) : -1,
    };
    const cloud = thereIn(this.cloud);
    if (cloud) drawCloud(context, view, cloud, this.cloudRow, this.theme);
    drawPoints(context, view, points, this.theme);
    if (this.ways) drawWays(context, view, this.ways, this.frame, this.theme);
    drawAdded(context, view, shown.added.data, shown.added_names, this.theme);
    if (path?.on_map) {
      const { on_map: mu, samples_on_map: samples, others_on_map: others } = path;
      const { radii, early, shown: last } = path;
      drawPath(context, view, { mu, samples, others, early, radii, shown: last }, this.theme);
    }
    drawNames(context, view, points, this.theme);
    this.drawHand(context, view);
  }

  /** Opacity of each point: how near it is to the slice that is drawn. @param {MapShown} shown */
  nearness({ classes }) {
    const off = this.state?.off_plane?.data;
    const farthest = Math.max(...(off ?? []), 1e-9);
    return classes.map((name, i) => {
      if (this.lit !== null) return this.lit === name ? 1 : UNLIT;
      return 1 - (1 - FARTHEST) * Math.min((off?.[i] ?? 0) / farthest, 1);
    });
  }

  /** How far the hand has gone along what is not drawn. @param {CanvasRenderingContext2D} context @param {View} view */
  drawHand(context, view) {
    if (!this.grabbed || !this.moves.active || !this.puck) return;
    const from = toData(view, this.grabbed.at);
    const way = this.hidden.map((value, i) => value - (this.grabbed?.hidden[i] ?? 0));
    const [x0, y0] = toPixel(view, from);
    const [x1, y1] = toPixel(view, [from[0] + (way[0] ?? 0), from[1] + (way[1] ?? 0)]);
    context.lineWidth = 2;
    context.setLineDash([4, 3]);
    line(context, this.theme.warning, x0, y0, x1, y1);
    context.setLineDash([]);
    const names = this.labels().slice(this.shown?.axes.length);
    const text = this.hidden.map((value, i) => `${names[i]} ${formatted(value)}`).join("  ");
    context.textAlign = "center";
    context.textBaseline = "bottom";
    haloed(context, text, x1, y1 - 12, this.theme);
  }

  // --- words ---
  words() {
    const { shown, state, puck } = this;
    if (!shown || !puck) return {};
    const labels = this.labels();
    const drawn = this.flat ? [puck[0]] : puck;
    const at = [...drawn, ...this.hidden].map((v, i) => `${labels[i]} ${formatted(v)}`).join(", ");
    say(this.parts.readout, drawn.map((value) => formatted(value)).join(", "));
    const selected = shown.selected === null ? "none" : (shown.names[shown.selected] ?? "none");
    /** @type {Record<string, string>} */
    const words = {
      puck: `Puck at ${at}`,
      selected: `Selected motion: ${selected}`,
      colouring: `Coloured by ${shown.colouring}`,
      points: this.listed,
    };
    if (state?.covariance) {
      const { major, minor } = ellipseOf(state.covariance.data);
      words.sigma = `Sigma on the map: ${formatted(major)} by ${formatted(minor)}`;
    }
    if (state?.extrapolation != null) {
      const far = `${formatted(state.extrapolation, 1)} times the usual gap between motions`;
      words.extrapolation = this.warned
        ? `Extrapolating: ${far} away`
        : `Near what was learned: ${far}`;
    }
    if (shown.added_names.length) words.added = `Your points: ${shown.added_names.join(", ")}`;
    const cloud = thereIn(this.cloud);
    if (cloud) words.belief = wordsOnCloud(cloud, this.cloudRow);
    if (this.ways) words.ways = "A straight and a shortest way to another motion are drawn";
    if (this.path?.on_map) words.path = wordsOnPath(this.path, this.path.on_map.data);
    return words;
  }
}

/** @param {PathShown} path @param {Float32Array} mu */
export function wordsOnPath(path, mu) {
  const count = mu.length / 2 - 1; // of steps; the first of them is called 1 on every panel
  const last = Math.min(path.shown, count);
  const [x, y] = [mu[2 * last] ?? 0, mu[2 * last + 1] ?? 0];
  return `Recognition at iteration ${Math.min(last + 1, count)} of ${count}: ${formatted(x)}, ${formatted(y)}, sigma ${formatted(path.radii.data[last])}`;
}
