/**
 * What both boards have in common: a plot that zooms, a puck that the hand moves at once, words.
 *
 * The puck stands where the hand put it until the server has heard of its last move; what the
 * server says before that is older than what one sees.
 */

import { theme } from "./colors.js";
import { Gestures } from "./gestures.js";
import { Moves } from "./moves.js";
import { element, isDark, onSchemeChange, Surface, say } from "./page.js";
import { drawAxes, drawPuck, PUCK } from "./plot.js";
import { clamp, closer, magnification, moved, toData, toPixel, within } from "./scales.js";

/** @typedef {import("./scales.js").Box} Box */
/** @typedef {import("./scales.js").Extent} Extent */
/** @typedef {import("./scales.js").Point} Point */
/** @typedef {import("./scales.js").View} View */
/** @typedef {import("./messages.js").Asked} Asked */
/** @typedef {import("./messages.js").Zoom} Zoom */
/** @typedef {import("./moves.js").Move} Move */
/** @typedef {(asked: Asked) => void} Ask */

const SAY_MS = 400; // a screen reader hears of what has rested as long
const MOST_ZOOM = 60;
const TOUCH_REACH = 26; // pixels round the puck that a finger grabs it in
/** @type {Record<string, Point>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** The name of a board in a slot. @type {(kind: string, slot: number) => string} */
export const nameOf = (kind, slot) => (slot ? `${kind}-${slot + 1}` : kind);

/** The elements of a board. @param {string} title @param {string} label @param {string} name */
function partsOf(title, label, name) {
  const unzoom = element("button", {
    class: "rb-chip",
    type: "button",
    title: "Show all",
    hidden: true,
  });
  const heading = element("span", { class: "rb-title", text: title });
  const readout = element("span", { class: "rb-readout" });
  const tools = element("span", { class: "rb-tools" }, [unzoom]);
  const mark = element("div", { class: "rb-mark", hidden: true });
  const tip = element("div", { class: "rb-tip", hidden: true });
  const said = element("div", { class: "rb-unseen", "aria-live": "polite" });
  const told = element("div", { class: "rb-unseen rb-told", id: `rb-${name}-told` });
  const plot = element("div", {
    class: "rb-plot",
    tabindex: "0",
    role: "application",
    "aria-label": label,
    "aria-describedby": told.id,
  });
  plot.append(mark, tip);
  const legend = element("aside", { class: "rb-legend" });
  const root = element(
    "section",
    { class: `rb-board rb-${name.split("-")[0]}`, "data-board": name },
    [
      element("header", { class: "rb-head" }, [heading, readout, tools]),
      element("div", { class: "rb-body" }, [plot, legend]),
      said,
      told,
    ],
  );
  return { root, heading, readout, tools, unzoom, plot, mark, tip, legend, said, told };
}

export class Board {
  /**
   * @param {Ask} ask
   * @param {() => void} looked called when a person has zoomed
   * @param {{ title: string, label: string, name: string }} words
   */
  constructor(ask, looked, { title, label, name }) {
    this.ask = ask;
    this.looked = looked;
    this.name = name;
    this.theme = theme(isDark());
    /** @type {Extent | null} */ this.home = null;
    this.of = ""; // what the board shows; a zoom holds for that
    /** @type {Zoom | null} */ this.zoom = null;
    /** @type {Point | null} */ this.puck = null;
    /** @type {Point | null} */ this.hovered = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */ this.saying = undefined;
    this.moves = new Moves((move) => {
      const asked = this.asked(move);
      if (asked) this.ask(asked);
    });
    this.parts = partsOf(title, label, name);
    this.parts.unzoom.addEventListener("click", () => this.look(null));
    this.surface = new Surface(this.parts.plot, (context) => this.paint(context));
    new Gestures(this.parts.plot, this.hands());
    this.parts.plot.addEventListener("keydown", (event) => this.key(event));
    onSchemeChange(() => {
      this.theme = theme(isDark());
      this.surface.request();
    });
  }

  get root() {
    return this.parts.root;
  }

  // --- for each board to say ---
  /** The window to draw in this box. @param {Extent} extent @param {Box} _box @returns {Extent} */
  fitted(extent, _box) {
    return extent;
  }
  /** The part of this box that the plot fills. @param {Box} box @returns {Box} */
  shaped(box) {
    return box;
  }
  /** Pixels around the plot. @returns {{ left: number, right: number, top: number, bottom: number }} */
  margins() {
    return { left: 46, right: 8, top: 6, bottom: 30 };
  }
  /** @param {CanvasRenderingContext2D} _context @param {View} _view */
  content(_context, _view) {}
  /** Whether a tap there means a point. @param {Point} _at @returns {number} its index, -1 for none */
  pointAt(_at) {
    return -1;
  }
  /** @param {number} _index */
  select(_index) {}
  /** What stands beside the pointer. @param {Point} _at @returns {string} */
  describe(_at) {
    return "";
  }
  /** The axes' names. @returns {string[]} */
  labels() {
    return ["", ""];
  }
  /** How a move is said. @param {Move} _move @returns {Asked | null} */
  asked(_move) {
    return null;
  }
  /** All that one can see, in words, by name. @returns {Record<string, string>} */
  words() {
    return {};
  }
  /** Where the hand moves the puck to. @param {Point} to @returns {Point} */
  allowed(to) {
    return this.home ? within(this.home, to) : to;
  }
  /** Whether the second axis has nothing to say. */
  get bare() {
    return this.flat;
  }

  get flat() {
    return false; // one axis only
  }

  // --- the view ---
  /** @returns {View | null} */
  get view() {
    const { width, height } = this.surface;
    const extent = this.zoomed ?? this.home;
    if (!extent || width < 2) return null;
    const m = this.margins();
    const box = this.shaped({
      left: m.left,
      top: m.top,
      width: Math.max(width - m.left - m.right, 10),
      height: Math.max(height - m.top - m.bottom, 10),
    });
    return { extent: this.fitted(extent, box), box };
  }

  /** The part that is looked at; null for the whole. */
  get zoomed() {
    return this.zoom?.of === this.of ? this.zoom : null;
  }

  /** @param {number} factor @param {Point} about */
  zoomBy(factor, about) {
    const { view, home } = this;
    if (!view || !home) return;
    const whole = this.fitted(home, view.box);
    const now = magnification(view.extent, whole);
    const bounded = clamp(now * factor, 1, MOST_ZOOM) / now;
    const next = closer(view.extent, bounded, toData(view, about));
    this.look(now * bounded > 1.001 ? this.inside(next, whole) : null);
  }

  /** The extent moved so that it does not leave the whole. @param {Extent} extent @param {Extent} whole */
  inside(extent, whole) {
    const dx = Math.max(whole.left - extent.left, 0) + Math.min(whole.right - extent.right, 0);
    const dy = Math.max(whole.bottom - extent.bottom, 0) + Math.min(whole.top - extent.top, 0);
    return moved(extent, dx, dy);
  }

  /** A person looks at this part. @param {Extent | null} extent */
  look(extent) {
    this.zoomTo(extent && { of: this.of, ...extent });
    this.looked();
  }

  /** @param {Zoom | null} zoom */
  zoomTo(zoom) {
    this.zoom = zoom;
    this.showZoom();
  }

  showZoom() {
    const { view, home, zoomed } = this;
    this.parts.unzoom.hidden = zoomed === null;
    if (view && home) {
      const factor = magnification(view.extent, this.fitted(home, view.box));
      say(this.parts.unzoom, `${factor.toFixed(1)}× ⤢`);
    }
    this.surface.request();
  }

  /** The whole that there is to see. @param {Extent} home @param {string} of what the board shows */
  setHome(home, of) {
    this.home = home;
    this.of = of;
    this.showZoom();
  }

  /** @param {Point | null} puck */
  setPuck(puck) {
    this.puck = puck;
  }

  /** @param {number} dx @param {number} dy pixels */
  pan(dx, dy) {
    const { view, home } = this;
    if (!view || !home || !this.zoomed) return;
    const { extent, box } = view;
    const x = (-dx / box.width) * (extent.right - extent.left);
    const y = (dy / box.height) * (extent.top - extent.bottom);
    this.look(this.inside(moved(extent, x, y), this.fitted(home, box)));
  }

  // --- hands ---
  /** @returns {import("./gestures.js").Hands} */
  hands() {
    return {
      grabs: (at, touch) => this.grabs(at, touch),
      start: (at, event) => this.startMove(at, event),
      drag: (at, event) => this.moveTo(at, event, false),
      end: () => this.endMove(),
      tap: (at, event) => this.tap(at, event),
      hover: (at) => this.hover(at),
      zoom: (factor, about) => this.zoomBy(factor, about),
      pan: (dx, dy) => this.pan(dx, dy),
    };
  }

  /** @param {Point} at @param {boolean} touch */
  grabs(at, touch) {
    if (!this.view) return false;
    if (touch) return this.overPuck(at, TOUCH_REACH);
    return this.overPuck(at, PUCK) || this.pointAt(at) < 0;
  }

  /** @param {Point} at @param {number} reach pixels */
  overPuck(at, reach) {
    if (!this.view || !this.puck) return false;
    const [x, y] = toPixel(this.view, this.puck);
    return Math.hypot(x - at[0], y - at[1]) <= reach;
  }

  /** @param {Point} at @param {PointerEvent} event */
  tap(at, event) {
    const point = this.pointAt(at);
    if (point >= 0) {
      this.select(point);
      return;
    }
    this.startMove(at, event);
    this.endMove();
  }

  /** @param {Point} at @param {MouseEvent} event */
  startMove(at, event) {
    this.moves.begin();
    this.moveTo(at, event, true);
  }

  /** @param {Point} at @param {MouseEvent} _event @param {boolean} _first */
  moveTo(at, _event, _first) {
    if (!this.view) return;
    this.put(this.allowed(toData(this.view, at)));
    this.hover(at);
  }

  endMove() {
    this.moves.end();
    this.hover(null);
  }

  /** The puck stands there at once, and the server hears of it. @param {Point} to */
  put(to) {
    this.puck = to;
    this.moves.put(this.flat ? [to[0]] : to, []);
    this.surface.request();
    this.tell();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const way = ARROWS[event.key];
    if (!way || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    this.moves.keyed();
    this.step(way, event.shiftKey);
  }

  /** @param {Point} way @param {boolean} _shift */
  step([x, y], _shift) {
    if (!this.view || !this.puck) return;
    const { left, right, bottom, top } = this.view.extent;
    /** @type {Point} */
    const to = [this.puck[0] + (x * (right - left)) / 50, this.puck[1] + (y * (top - bottom)) / 50];
    this.put(this.allowed(to));
  }

  /** @param {Point | null} at */
  hover(at) {
    this.hovered = at;
    const text = at && !this.moves.active ? this.describe(at) : "";
    this.parts.tip.hidden = text === "";
    if (at && text) {
      say(this.parts.tip, text);
      const right = at[0] > this.surface.width / 2;
      const below = at[1] < 44;
      this.parts.tip.style.left = `${at[0] + (right ? -12 : 14)}px`;
      this.parts.tip.style.top = `${at[1] + (below ? 18 : -10)}px`;
      this.parts.tip.style.transform = `translate(${right ? "-100%" : "0"}, ${below ? "0" : "-100%"})`;
    }
    this.parts.plot.style.cursor = at && this.pointAt(at) >= 0 ? "pointer" : "crosshair";
    this.surface.request();
  }

  // --- words ---
  /** Bring the words up to date; a screen reader hears of the puck once it has rested. */
  tell() {
    const words = this.words();
    for (const [name, text] of Object.entries(words)) {
      let line = this.parts.told.querySelector(`[data-name="${name}"]`);
      if (!line) {
        line = element("p", { "data-name": name });
        this.parts.told.append(line);
      }
      say(line, text);
    }
    for (const line of this.parts.told.querySelectorAll("p")) {
      if (!((line.dataset.name ?? "") in words)) line.remove();
    }
    clearTimeout(this.saying);
    this.saying = setTimeout(() => say(this.parts.said, words.puck ?? ""), SAY_MS);
  }

  // --- painting ---
  /** @param {CanvasRenderingContext2D} context */
  paint(context) {
    const { view } = this;
    if (!view) return;
    drawAxes(context, view, this.theme, this.labels(), this.bare);
    const { left, top, width, height } = view.box;
    context.save();
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    this.content(context, view);
    context.restore();
    context.strokeStyle = this.theme.axis;
    context.lineWidth = 1;
    context.strokeRect(left + 0.5, top + 0.5, width - 1, height - 1);
    if (this.puck) drawPuck(context, toPixel(view, this.puck), view.box, this.theme, this.warned);
  }

  get warned() {
    return false;
  }
}
