/**
 * A motion as joint angles, and the clock that plays it. Pure: no page, no scene.
 * Frames count from 0 and may lie between two of a motion's.
 */

import { clamp } from "./scales.js";

/**
 * @typedef {object} Clock
 * @property {number} frame where it stands
 * @property {number} frames how many there are
 * @property {number} fps frames a second at speed 1
 * @property {number} speed
 * @property {boolean} loop
 * @property {boolean} playing
 */

/** The last frame that a clock can show. @type {(clock: Clock) => number} */
export const lastFrame = (clock) => Math.max(clock.frames - 1, 0);

/**
 * The clock some seconds later; without loop it stops at the last frame.
 * @type {(clock: Clock, seconds: number) => Clock}
 */
export function advanced(clock, seconds) {
  if (!clock.playing || clock.frames === 0) return clock;
  const last = lastFrame(clock);
  const frame = clock.frame + Math.max(seconds, 0) * clock.fps * clock.speed;
  if (frame < last) return { ...clock, frame };
  if (!clock.loop || last === 0) return { ...clock, frame: last, playing: false };
  return { ...clock, frame: frame % last };
}

/** Played from the start where it stands at the end. @type {(clock: Clock) => Clock} */
export function started(clock) {
  return { ...clock, playing: true, frame: clock.frame >= lastFrame(clock) ? 0 : clock.frame };
}

/** The same phase in a motion of another length. @type {(clock: Clock, frames: number, fps: number) => Clock} */
export function refitted(clock, frames, fps) {
  const last = Math.max(frames - 1, 0);
  const frame = clock.loop && last > 0 && clock.frame > last ? clock.frame % last : clock.frame;
  return { ...clock, frames, fps, frame: clamp(frame, 0, last) };
}

/**
 * Row of a (frames, columns) array at a frame, linear between two; the last one beyond the end.
 * @type {(angles: ArrayLike<number>, columns: number, frame: number, out: Float32Array) => void}
 */
export function sampled(angles, columns, frame, out) {
  const last = Math.max(angles.length / columns - 1, 0);
  const at = clamp(frame, 0, last);
  const low = Math.floor(at);
  const share = at - low;
  const from = low * columns;
  const to = Math.min(low + 1, last) * columns;
  for (let j = 0; j < columns; j++) {
    out[j] = angles[from + j] * (1 - share) + angles[to + j] * share;
  }
}

/**
 * Quaternion (x, y, z, w) of a rotation by `angle` about `axis` after a rest rotation (w, x, y, z).
 * @type {(rest: ArrayLike<number>, axis: ArrayLike<number>, k: number, angle: number) =>
 *   [number, number, number, number]}
 */
export function turned(rest, axis, k, angle) {
  const [w, x, y, z] = [rest[4 * k], rest[4 * k + 1], rest[4 * k + 2], rest[4 * k + 3]];
  const s = Math.sin(angle / 2);
  const c = Math.cos(angle / 2);
  const [a, b, d] = [axis[3 * k] * s, axis[3 * k + 1] * s, axis[3 * k + 2] * s];
  return [
    w * a + x * c + y * d - z * b,
    w * b - x * d + y * c + z * a,
    w * d + x * b - y * a + z * c,
    w * c - x * a - y * b - z * d,
  ];
}

/**
 * A vector turned by a quaternion (w, x, y, z), both given as the k-th of many.
 * @type {(rest: ArrayLike<number>, vector: ArrayLike<number>, k: number) => [number, number, number]}
 */
export function rotated(rest, vector, k) {
  const [w, x, y, z] = [rest[4 * k], rest[4 * k + 1], rest[4 * k + 2], rest[4 * k + 3]];
  const [a, b, c] = [vector[3 * k], vector[3 * k + 1], vector[3 * k + 2]];
  const tx = 2 * (y * c - z * b);
  const ty = 2 * (z * a - x * c);
  const tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

/**
 * Least and greatest of K motions (K, frames * joints) at each of their entries.
 * @type {(ghosts: ArrayLike<number>, count: number) => { low: Float32Array, high: Float32Array }}
 */
export function envelope(ghosts, count) {
  const size = ghosts.length / Math.max(count, 1);
  const low = new Float32Array(size).fill(Number.POSITIVE_INFINITY);
  const high = new Float32Array(size).fill(Number.NEGATIVE_INFINITY);
  for (let k = 0; k < count; k++) {
    for (let i = 0; i < size; i++) {
      const value = ghosts[k * size + i];
      if (value < low[i]) low[i] = value;
      if (value > high[i]) high[i] = value;
    }
  }
  return { low, high };
}
