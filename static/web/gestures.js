/**
 * What hands do on an element, by mouse, pen and finger: drag, tap, hover, zoom, pan.
 *
 * A mouse drags from where it is pressed. A finger may be the first of two, so it drags once it has
 * moved, or at once where `grabs` says that it holds something. Two fingers zoom and pan, the wheel
 * zooms, other mouse buttons pan.
 */

import { pageScale } from "./page.js";

/** @typedef {import("./scales.js").Point} Point */
/**
 * @typedef {object} Hands pixels are those that the element is drawn in
 * @property {(at: Point, touch: boolean) => boolean} grabs whether something is held there
 * @property {(at: Point, event: PointerEvent) => void} start of a drag
 * @property {(at: Point, event: PointerEvent) => void} drag
 * @property {() => void} end of a drag, however it ended
 * @property {(at: Point, event: PointerEvent) => void} tap
 * @property {(at: Point | null) => void} hover null when the pointer has left
 * @property {(factor: number, about: Point) => void} zoom
 * @property {(dx: number, dy: number) => void} pan
 */

const SLOP = 4; // pixels that a press may move and still is a tap
const TOUCH_SLOP = 7;
const WHEEL_RATE = 0.0018; // of zoom for a pixel of the wheel

export class Gestures {
  /**
   * @param {HTMLElement} target
   * @param {Hands} hands
   */
  constructor(target, hands) {
    this.target = target;
    this.hands = hands;
    /** @type {Map<number, Point>} */
    this.fingers = new Map();
    /** @type {"idle" | "pressed" | "dragging" | "panning" | "pinching"} */
    this.state = "idle";
    /** @type {Point} */
    this.from = [0, 0];
    this.still = true; // not moved since it was pressed
    target.addEventListener("pointerdown", (event) => this.down(event));
    target.addEventListener("pointermove", (event) => this.move(event));
    target.addEventListener("pointerup", (event) => this.up(event));
    target.addEventListener("pointercancel", (event) => this.cancel(event));
    target.addEventListener("lostpointercapture", (event) => this.cancel(event));
    target.addEventListener("pointerleave", () => hands.hover(null));
    target.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    target.addEventListener("keydown", () => target.classList.remove("rb-by-hand"));
    target.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @param {MouseEvent} event @returns {Point} */
  at(event) {
    const box = this.target.getBoundingClientRect();
    const scale = pageScale();
    return [(event.clientX - box.left) / scale, (event.clientY - box.top) / scale];
  }

  /** @param {PointerEvent} event */
  down(event) {
    const at = this.at(event);
    this.fingers.set(event.pointerId, at);
    this.target.setPointerCapture(event.pointerId);
    this.target.classList.add("rb-by-hand"); // no ring round what a hand is on
    this.target.focus({ preventScroll: true });
    event.preventDefault();
    event.stopPropagation();
    if (this.fingers.size > 1) this.pinch();
    else if (event.button > 0) this.state = "panning";
    else this.press(at, event);
  }

  /** @param {Point} at @param {PointerEvent} event */
  press(at, event) {
    this.from = at;
    this.still = true;
    this.state = "pressed";
    if (this.hands.grabs(at, event.pointerType === "touch")) this.startDrag(at, event);
  }

  /** @param {Point} at @param {PointerEvent} event */
  startDrag(at, event) {
    this.state = "dragging";
    this.hands.start(at, event);
  }

  pinch() {
    if (this.state === "dragging") this.hands.end();
    this.state = "pinching";
  }

  /** @param {PointerEvent} event */
  move(event) {
    const at = this.at(event);
    const before = this.fingers.get(event.pointerId);
    if (!before) {
      this.hands.hover(at);
      return;
    }
    if (this.state === "pinching") this.pinched(event.pointerId, at);
    this.fingers.set(event.pointerId, at);
    if (this.state === "panning") this.hands.pan(at[0] - before[0], at[1] - before[1]);
    const slop = event.pointerType === "touch" ? TOUCH_SLOP : SLOP;
    if (Math.hypot(at[0] - this.from[0], at[1] - this.from[1]) > slop) this.still = false;
    if (this.state === "pressed" && !this.still) this.startDrag(this.from, event);
    if (this.state === "dragging") this.hands.drag(at, event);
  }

  /** @param {number} id @param {Point} at */
  pinched(id, at) {
    const before = this.fingers.get(id);
    const other = [...this.fingers].find(([one]) => one !== id)?.[1];
    if (!before || !other) return;
    const apart = Math.hypot(before[0] - other[0], before[1] - other[1]);
    const now = Math.hypot(at[0] - other[0], at[1] - other[1]);
    this.hands.zoom(Math.max(now, 1) / Math.max(apart, 1), other);
  }

  /** @param {PointerEvent} event */
  up(event) {
    if (!this.fingers.delete(event.pointerId)) return;
    const { state } = this;
    if (this.fingers.size === 0) this.state = "idle";
    if (state === "dragging") this.hands.end();
    if (state === "pressed") this.hands.tap(this.at(event), event);
  }

  /** @param {PointerEvent} event */
  cancel(event) {
    if (!this.fingers.delete(event.pointerId)) return;
    if (this.state === "dragging") this.hands.end();
    if (this.fingers.size === 0) this.state = "idle";
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    event.preventDefault();
    event.stopPropagation();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 * event.deltaY : event.deltaY;
    const rate = event.ctrlKey ? 5 * WHEEL_RATE : WHEEL_RATE; // a touchpad's pinch comes as ctrl
    this.hands.zoom(Math.exp(-pixels * rate), this.at(event));
  }
}
