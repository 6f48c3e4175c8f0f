/**
 * The hand's moves of a puck on their way to the server: numbered, one gesture from press to
 * release, at most one every 40 ms and always the last.
 */

import { Coalescer } from "./coalesce.js";

/** @typedef {{ to: number[], axes: number[], gesture: number, number: number, done: boolean }} Move */

export const SEND_MS = 40;
const FORGET_MS = 2000; // a move that the server has not answered by then is lost
const KEYS_REST_MS = 300; // keys that follow each other faster are one gesture
const UNSAID_MS = 300; // how long a server that does not say what it heard is not believed

// Numbers over all boards of the page.
const counter = { gesture: 0, number: 0 };

export class Moves {
  /** @param {(move: Move) => void} send */
  constructor(send) {
    this.coalescer = new Coalescer(send, SEND_MS);
    this.gesture = 0;
    this.active = false;
    /** @type {Move | null} */
    this.last = null;
    this.number = 0;
    this.time = Number.NEGATIVE_INFINITY;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.resting = undefined;
  }

  begin() {
    this.end();
    this.gesture = ++counter.gesture;
    this.active = true;
  }

  /** @param {number[]} to @param {number[]} axes */
  put(to, axes) {
    this.last = { to, axes, gesture: this.gesture, number: ++counter.number, done: false };
    this.number = counter.number;
    this.time = performance.now();
    this.coalescer.offer(this.last);
  }

  end() {
    clearTimeout(this.resting);
    this.resting = undefined;
    this.active = false;
    if (!this.last) return;
    const last = { ...this.last, number: ++counter.number, done: true };
    this.last = null;
    this.number = last.number;
    this.time = performance.now();
    this.coalescer.offer(last);
    this.coalescer.flush();
  }

  /** A key was pressed that moves the puck; a run of them is one gesture. */
  keyed() {
    if (this.resting === undefined) this.begin();
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.end(), KEYS_REST_MS);
  }

  /**
   * Whether the server's word on the puck is newer than the hand's.
   * @param {number | null} heard number of the last move that is in it
   */
  accepts(heard) {
    if (this.active) return false;
    const ago = performance.now() - this.time;
    if (heard === null) return ago > UNSAID_MS;
    return heard >= this.number || ago > FORGET_MS;
  }
}
