/**
 * Plays what the server sent once, at the screen's own rate. It needs no server: the server learns
 * where playback rests, and what was chosen.
 */

import { advanced, refitted, started } from "./motion.js";
import { clamp } from "./scales.js";

/** @typedef {import("./motion.js").Clock} Clock */
/** @typedef {import("./messages.js").PlaybackShown} PlaybackShown */

const REST_MS = 200; // a frame that one has gone to is told when it has rested so long

export class Playback {
  /**
   * @param {import("./robots.js").Robots} robots
   * @param {(asked: import("./messages.js").Asked) => void} ask
   * @param {(now: boolean) => void} changed called when the clock is another; now: in a frame
   */
  constructor(robots, ask, changed) {
    this.robots = robots;
    this.ask = ask;
    this.changed = changed;
    /** @type {Clock} */
    this.clock = { frame: 0, frames: 0, fps: 25, speed: 1, loop: true, playing: false };
    /** @type {number | null} */ this.number = null;
    /** @type {number | null} */ this.wanted = null; // a frame for a motion that is still to come
    /** @type {ReturnType<typeof setTimeout> | undefined} */ this.resting = undefined;
    this.time = performance.now();
    this.moved = true;
    this.frames = 0; // pictures so far
    requestAnimationFrame((now) => this.tick(now));
  }

  /** @param {number} now milliseconds */
  tick(now) {
    const before = this.clock;
    this.clock = advanced(before, (now - this.time) / 1000);
    this.time = now;
    if (before.playing && !this.clock.playing) this.tellPlaying();
    const moved = this.moved || this.clock.frame !== before.frame;
    this.moved = false;
    this.robots.pose(this.clock.frame, moved);
    if (moved) {
      this.frames += 1;
      this.changed(true);
    }
    requestAnimationFrame((next) => this.tick(next));
  }

  /** @param {Clock} clock */
  set(clock) {
    this.clock = clock;
    this.moved = true;
    this.changed(false);
  }

  // --- what the server shows ---
  /** @param {PlaybackShown} shown */
  show({ number, playing, frame, speed, loop }) {
    if (number === this.number) return;
    this.number = number;
    this.wanted = frame;
    this.set({ ...this.clock, playing, speed, loop });
    this.fit();
  }

  /** @param {import("./messages.js").MotionShown} motion */
  showMotion(motion) {
    this.robots.showMotion(motion);
    this.fit();
  }

  fit() {
    const { frames, fps } = this.robots.length;
    if (frames === 0) return;
    const clock = this.wanted === null ? this.clock : { ...this.clock, frame: this.wanted };
    this.wanted = null;
    this.set(refitted(clock, frames, fps));
  }

  // --- what a person does ---
  toggle() {
    const { clock } = this;
    this.set(clock.playing ? { ...clock, playing: false } : started(clock));
    this.tellPlaying();
  }

  tellPlaying() {
    this.ask({ type: "SetPlaying", playing: this.clock.playing, frame: this.clock.frame });
  }

  /** Go to a frame, and rest on it. @param {number} frame */
  seek(frame) {
    this.set({
      ...this.clock,
      playing: false,
      frame: clamp(frame, 0, Math.max(this.clock.frames - 1, 0)),
    });
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.ask({ type: "Seek", frame: this.clock.frame }), REST_MS);
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.set({ ...this.clock, speed });
    this.ask({ type: "SetSpeed", speed });
  }

  /** @param {boolean} loop */
  setLoop(loop) {
    this.set({ ...this.clock, loop });
    this.ask({ type: "SetLoop", loop });
  }
}
