/** Time: play, scrub, speed and loop, the joint curves over the same axis, what was observed. */

import { Coalescer } from "./coalesce.js";
import { ofSlot, theme } from "./colors.js";
import { drawCurves, rangeOf } from "./curves.js";
import { envelope } from "./motion.js";
import { SEND_MS } from "./moves.js";
import { element, isDark, onSchemeChange, pageScale, Surface, say } from "./page.js";
import { clamp, formatted } from "./scales.js";

/** @typedef {import("./messages.js").CurvesShown} CurvesShown */
/** @typedef {import("./messages.js").MotionShown} MotionShown */

const SPEEDS = [0.25, 0.5, 1, 2];
const EDGE = 10; // pixels left and right of the curves
const HANDLE_REACH = 9; // pixels from the observed part's end that the pointer still means it
const LEAST_OBSERVED = 0.05;

/** @param {string} label @param {string} text @returns {HTMLButtonElement} */
const button = (label, text) =>
  element("button", {
    class: "rb-button",
    type: "button",
    "aria-label": label,
    title: label,
    text,
  });

export class TimeBar {
  /**
   * @param {import("./playback.js").Playback} playback
   * @param {(asked: import("./messages.js").Asked) => void} ask
   */
  constructor(playback, ask) {
    this.playback = playback;
    this.ask = ask;
    /** @type {CurvesShown | null} */ this.curves = null;
    /** @type {(MotionShown | null)[]} */ this.motions = [null, null]; // of each slot's model
    /** @type {({ low: Float32Array, high: Float32Array } | null)[]} */ this.bands = [null, null];
    /** @type {number | null} */ this.observed = null;
    /** @type {"time" | "observed" | null} */ this.holding = null;
    this.theme = theme(isDark());
    this.told = new Coalescer(
      (/** @type {number} */ share) => ask({ type: "SetObserved", share }),
      SEND_MS,
    );
    this.play = button("Play", "▶");
    this.play.classList.add("rb-play");
    this.time = element("span", { class: "rb-time", role: "status", "aria-live": "off" });
    this.value = element("span", { class: "rb-value" });
    this.whose = element("span", { class: "rb-whose" });
    this.joint = element("select", { class: "rb-select", "aria-label": "Joint" });
    this.speed = element(
      "select",
      { class: "rb-select", "aria-label": "Speed" },
      SPEEDS.map((speed) => element("option", { value: speed, text: `${speed}×` })),
    );
    this.loop = button("Loop", "⟳");
    this.plot = element("div", {
      class: "rb-curves",
      tabindex: "0",
      role: "slider",
      "aria-label": "Frame",
      "aria-valuemin": 0,
    });
    this.plot.append(this.whose);
    this.root = element("section", { class: "rb-timebar", "aria-label": "Time" }, [
      element("div", { class: "rb-row" }, [
        this.play,
        this.time,
        this.value,
        element("span", { class: "rb-grow" }),
        this.joint,
        this.speed,
        this.loop,
      ]),
      this.plot,
    ]);
    this.surface = new Surface(this.plot, (context, width, height) =>
      this.paint(context, width, height),
    );
    this.listen();
    this.refresh();
  }

  listen() {
    const { playback } = this;
    this.play.addEventListener("click", () => playback.toggle());
    this.loop.addEventListener("click", () => playback.setLoop(!playback.clock.loop));
    this.speed.addEventListener("change", () => playback.setSpeed(Number(this.speed.value)));
    this.joint.addEventListener("change", () => {
      const joint = this.joint.value === "" ? null : Number(this.joint.value);
      if (this.curves) this.showCurves({ ...this.curves, joint });
      this.ask({ type: "SetJoint", joint });
    });
    this.plot.addEventListener("pointerdown", (event) => this.press(event));
    this.plot.addEventListener("pointermove", (event) => this.move(event));
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) {
      this.plot.addEventListener(end, () => {
        if (this.holding === "observed") this.told.flush();
        this.holding = null;
      });
    }
    this.plot.addEventListener("keydown", (event) => this.key(event));
    onSchemeChange(() => {
      this.theme = theme(isDark());
      this.surface.request();
    });
  }

  // --- what the server shows ---
  /** @param {CurvesShown} curves */
  showCurves(curves) {
    const before = this.curves?.names ?? [];
    this.curves = curves;
    if (this.holding !== "observed") this.observed = curves.observed;
    if (String(before) !== String(curves.names)) {
      this.joint.replaceChildren(
        element("option", { value: "", text: "all joints" }),
        ...curves.names.map((_, i) => element("option", { value: i })),
      );
    }
    curves.names.forEach((name, i) => {
      const option = this.joint.options[i + 1];
      if (option) say(option, curves.unseen?.data[i] ? `${name} (inferred)` : name);
    });
    this.joint.value = curves.joint === null ? "" : String(curves.joint);
    this.refresh();
  }

  /** @param {MotionShown} motion */
  showMotion(motion) {
    if (motion.slot === null) return;
    this.motions[motion.slot] = motion;
    this.bands[motion.slot] =
      motion.ghosts && motion.samples
        ? envelope(motion.ghosts.data, motion.ghosts.shape[0] ?? 0)
        : null;
    this.refresh();
  }

  get active() {
    return this.curves?.active ?? 0;
  }

  /** Of the active model. */
  get motion() {
    return this.motions[this.active] ?? null;
  }

  get band() {
    return this.bands[this.active] ?? null;
  }

  /** Of the other models on the boards, where one joint is drawn. @returns {import("./curves.js").Other[]} */
  get others() {
    const { curves } = this;
    const joint = curves?.joint ?? null;
    if (!curves || joint === null) return [];
    return curves.models.flatMap((_, slot) => {
      const angles = this.motions[slot]?.angles;
      if (slot === this.active || !angles) return [];
      const { low = null, high = null } = this.bands[slot] ?? {};
      const columns = angles.shape[1] ?? 0;
      const column = curves.columns.data[slot * curves.names.length + joint] ?? 0;
      return [{ angles: angles.data, low, high, columns, joint: column, slot }];
    });
  }

  /** Which curve is whose, where there are two. */
  legend() {
    const { curves } = this;
    const drawn = curves && curves.joint !== null && curves.models.length > 1 ? curves.models : [];
    if (this.whose.childElementCount !== drawn.length) {
      this.whose.replaceChildren(...drawn.map(() => element("span")));
    }
    drawn.forEach((name, slot) => {
      const one = /** @type {HTMLElement} */ (this.whose.children[slot]);
      say(one, `━ ${name} `);
      one.style.color = ofSlot(this.theme, slot).curve;
    });
  }

  // --- hands ---
  /** Pixels from the plot's left edge. @param {PointerEvent} event */
  across(event) {
    return (event.clientX - this.plot.getBoundingClientRect().left) / pageScale();
  }

  /** @param {number} x pixels in the plot @returns {number} share of the whole */
  shareAt(x) {
    return clamp((x - EDGE) / Math.max(this.surface.width - 2 * EDGE, 1), 0, 1);
  }

  /** Share of the axis where the observed part ends; it is a share of the reference. */
  get observedEnd() {
    if (this.observed === null) return null;
    const frames = this.playback.clock.frames;
    const reference = this.curves?.reference?.shape[0] ?? frames;
    return frames > 1 ? (this.observed * (reference - 1)) / (frames - 1) : this.observed;
  }

  /** @param {PointerEvent} event */
  press(event) {
    if (event.button > 0) return;
    const x = this.across(event);
    const end = this.observedEnd;
    const handle = end === null ? null : EDGE + end * (this.surface.width - 2 * EDGE);
    const onHandle = handle !== null && Math.abs(x - handle) <= HANDLE_REACH;
    this.holding = onHandle ? "observed" : "time";
    this.plot.setPointerCapture(event.pointerId);
    this.move(event);
  }

  /** @param {PointerEvent} event */
  move(event) {
    const x = this.across(event);
    const share = this.shareAt(x);
    const { frames } = this.playback.clock;
    if (this.holding === "time") this.playback.seek(share * (frames - 1));
    if (this.holding === "observed") {
      const reference = this.curves?.reference?.shape[0] ?? frames;
      const part = reference > 1 ? (share * (frames - 1)) / (reference - 1) : share;
      this.observed = clamp(part, LEAST_OBSERVED, 1);
      this.told.offer(this.observed);
      this.refresh();
    }
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { clock } = this.playback;
    const to = {
      ArrowLeft: Math.ceil(clock.frame) - 1,
      ArrowRight: Math.floor(clock.frame) + 1,
      Home: 0,
      End: clock.frames - 1,
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.playback.seek(to);
  }

  // --- showing ---
  /** Bring everything up to the clock. @param {boolean} [now] in this very frame */
  refresh(now = false) {
    const { clock } = this.playback;
    const frame = Math.round(clock.frame);
    say(this.play, clock.playing ? "❚❚" : "▶");
    this.play.setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    this.play.title = `${clock.playing ? "Pause" : "Play"} (Space)`;
    this.loop.setAttribute("aria-pressed", String(clock.loop));
    if (document.activeElement !== this.speed) this.speed.value = String(clock.speed);
    say(
      this.time,
      `${formatted(clock.frame / clock.fps)} s · ${frame} / ${Math.max(clock.frames - 1, 0)}`,
    );
    this.plot.setAttribute("aria-valuemax", String(Math.max(clock.frames - 1, 0)));
    this.plot.setAttribute("aria-valuenow", String(frame));
    const joint = this.curves?.joint ?? null;
    const columns = this.motion?.angles.shape[1] ?? 0;
    const value = joint === null ? undefined : this.motion?.angles.data[frame * columns + joint];
    say(
      this.value,
      value === undefined ? "" : `${this.curves?.names[joint ?? 0]} ${formatted(value)} rad`,
    );
    this.legend();
    if (now) this.surface.draw();
    else this.surface.request();
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
  paint(context, width, height) {
    const { clock } = this.playback;
    const box = { left: EDGE, top: 6, width: width - 2 * EDGE, height: height - 21 };
    const { curves, motion } = this;
    const angles = motion?.angles ?? null;
    const low = curves?.low?.data ?? this.band?.low ?? null;
    const high = curves?.high?.data ?? this.band?.high ?? null;
    const what = {
      angles: angles?.data ?? new Float32Array(0),
      reference: curves?.reference?.data ?? null,
      low,
      high,
      columns: curves?.names.length ?? angles?.shape[1] ?? 1,
      joint: curves?.joint ?? null,
      frames: Math.max(clock.frames, 2),
      fps: clock.fps,
      slot: this.active,
      others: this.others,
    };
    const view = {
      extent: { left: 0, right: what.frames - 1, ...rangeOf(what) },
      box,
    };
    drawCurves(context, view, what, this.theme, this.observedEnd, clock.frame);
  }
}
