/**
 * How much the motion changes in each step of the two ways: the straight line solid, the shortest
 * dashed, a colour a model. A click or the arrow keys go to a step; the steepest one is marked.
 */

import { ofSlot, theme } from "./colors.js";
import { element, isDark, onSchemeChange, pageScale, Surface } from "./page.js";
import { FONT, haloed, line } from "./plot.js";
import { clamp, formatted, ticks, toPixel } from "./scales.js";
import { stepNow } from "./ways.js";

/** @typedef {import("./messages.js").WaysShown} WaysShown */
/** @typedef {import("./scales.js").View} View */

const EDGES = { left: 30, right: 8, top: 16, bottom: 18 }; // pixels
const HEADROOM = 1.12; // above the highest step

export class Steps {
  /** @param {(asked: import("./messages.js").Asked) => void} ask */
  constructor(ask) {
    this.ask = ask;
    this.name = "steps";
    /** @type {(WaysShown | null)[]} */ this.ways = [null, null];
    this.frame = 0;
    this.theme = theme(isDark());
    this.root = element("div", {
      class: "rb-steps",
      tabindex: "0",
      role: "slider",
      "aria-label": "Step of the way",
      "aria-valuemin": 0,
    });
    this.surface = new Surface(this.root, (context, width, height) =>
      this.paint(context, width, height),
    );
    this.root.addEventListener("pointerdown", (event) => {
      this.root.setPointerCapture(event.pointerId);
      this.goTo(event);
    });
    this.root.addEventListener("pointermove", (event) => {
      if (event.buttons) this.goTo(event);
    });
    this.root.addEventListener("keydown", (event) => this.key(event));
    onSchemeChange(() => {
      this.theme = theme(isDark());
      this.surface.request();
    });
  }

  /** @param {WaysShown} shown */
  show(shown) {
    this.ways[shown.slot] = shown.straight ? shown : null;
    this.refresh();
  }

  /** Of two models only the first is left. @param {number} pairs */
  showPairs(pairs) {
    if (pairs < 2 && this.ways[1]) {
      this.ways[1] = null;
      this.refresh();
    }
  }

  /** @param {number} frame */
  atFrame(frame) {
    this.frame = frame;
    if (this.shown.some(({ shares }) => shares)) this.surface.request();
  }

  get shown() {
    return this.ways.filter((one) => one !== null);
  }

  get count() {
    return this.shown[0]?.changes?.data.length ?? 0;
  }

  /** The step that is gone to; it comes back with the next message. @type {number | null} */
  asked = null;

  /** @param {number} step */
  put(step) {
    const to = clamp(Math.round(step), 0, this.count);
    if (to === this.asked || this.count === 0) return;
    this.asked = to;
    this.ask({ type: "WalkTo", step: to });
  }

  /** @param {PointerEvent} event */
  goTo(event) {
    const across = (event.clientX - this.root.getBoundingClientRect().left) / pageScale();
    const { left, right } = EDGES;
    this.put(((across - left) / Math.max(this.surface.width - left - right, 1)) * this.count);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const now = this.shown[0]?.at ?? 0;
    const to = { ArrowLeft: now - 1, ArrowRight: now + 1, Home: 0, End: this.count }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.put(to);
  }

  refresh() {
    const [first] = this.shown;
    this.asked = first?.at ?? null;
    this.root.setAttribute("aria-valuemax", String(this.count));
    this.root.setAttribute("aria-valuenow", String(first?.at ?? 0));
    const words = this.shown.map(({ title, changes, steepest }) => {
      const change = formatted(changes?.data[steepest] ?? 0, 1);
      return `${title}: steepest from step ${steepest} to ${steepest + 1}, ${change} degrees`;
    });
    this.root.setAttribute("aria-valuetext", [`step ${first?.at ?? "none"}`, ...words].join("; "));
    this.surface.request();
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
  paint(context, width, height) {
    const { left, right, top, bottom } = EDGES;
    const box = { left, top, width: width - left - right, height: height - top - bottom };
    const colors = this.theme;
    context.font = FONT;
    context.fillStyle = colors.plot;
    context.fillRect(box.left, box.top, box.width, box.height);
    if (this.count === 0) {
      context.fillStyle = colors.quiet;
      context.fillText("measuring …", box.left + 8, box.top + box.height / 2);
      return;
    }
    const both = this.shown.flatMap((ways) => [ways.changes, ways.shortest_changes]);
    const most = Math.max(...both.flatMap((one) => [...(one?.data ?? [])]), 1e-3);
    const extent = { left: 0, right: this.count, bottom: 0, top: HEADROOM * most };
    /** @type {View} */ const view = { extent, box };
    this.drawAxes(context, view);
    this.ways.forEach((ways, slot) => {
      if (ways) this.drawChanges(context, view, ways, slot);
    });
    this.drawTitles(context, view);
    const [first] = this.shown;
    const step = first ? stepNow(first, this.frame) : null;
    if (step === null) return;
    const [x] = toPixel(view, [step, 0]);
    context.lineWidth = 1.5;
    line(context, colors.ink, x, box.top, x, box.top + box.height);
  }

  /** @param {CanvasRenderingContext2D} context @param {View} view */
  drawAxes(context, view) {
    const { box, extent } = view;
    const colors = this.theme;
    context.fillStyle = colors.quiet;
    context.lineWidth = 1;
    context.textAlign = "right";
    context.textBaseline = "middle";
    const degrees = ticks(0, extent.top, box.height / 30);
    for (const degree of degrees) {
      const y = Math.round(toPixel(view, [0, degree])[1]) + 0.5;
      line(context, colors.grid, box.left, y, box.left + box.width, y);
      context.fillText(`${formatted(degree, degrees[1] < 1 ? 1 : 0)}°`, box.left - 4, y);
    }
    context.textBaseline = "top";
    context.textAlign = "left";
    context.fillText("motion change a step", box.left, box.top + box.height + 4);
    context.textAlign = "right";
    context.fillText(`${extent.right} steps`, box.left + box.width, box.top + box.height + 4);
  }

  /** @param {CanvasRenderingContext2D} context @param {View} view @param {WaysShown} ways @param {number} slot */
  drawChanges(context, view, { changes, shortest_changes: shortest, steepest }, slot) {
    if (!changes || !shortest) return;
    const { curve } = ofSlot(this.theme, slot);
    context.strokeStyle = curve;
    for (const [{ data }, dash, width] of /** @type {const} */ ([
      [shortest, [4, 3], 1.2],
      [changes, [], 2],
    ])) {
      context.setLineDash([...dash]);
      context.lineWidth = width;
      context.beginPath();
      data.forEach((value, i) => {
        context.lineTo(...toPixel(view, [i + 0.5, value]));
      });
      context.stroke();
    }
    context.setLineDash([]);
    context.beginPath();
    const at = toPixel(view, [steepest + 0.5, changes.data[steepest] ?? 0]);
    context.arc(...at, 4.5, 0, 2 * Math.PI);
    context.fillStyle = this.theme.plot;
    context.fill();
    context.stroke();
  }

  /** @param {CanvasRenderingContext2D} context @param {View} view */
  drawTitles(context, { box }) {
    context.textAlign = "left";
    context.textBaseline = "bottom";
    let x = box.left;
    this.ways.forEach((ways, slot) => {
      if (!ways) return;
      haloed(context, ways.title, x, box.top - 2, this.theme, ofSlot(this.theme, slot).curve);
      x += context.measureText(ways.title).width + 12;
    });
    context.textAlign = "right";
    context.fillStyle = this.theme.quiet;
    context.fillText("— straight  - - shortest", box.left + box.width, box.top - 2);
  }
}
