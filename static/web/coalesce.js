/** Values that come faster than they may be sent: the newest is, and the last one always. */

/** @template Value */
export class Coalescer {
  /**
   * @param {(value: Value) => void} send
   * @param {number} interval least milliseconds between two sends
   * @param {() => number} now milliseconds
   * @param {(callback: () => void, milliseconds: number) => unknown} later
   */
  constructor(send, interval, now = () => performance.now(), later = (f, ms) => setTimeout(f, ms)) {
    this.send = send;
    this.interval = interval;
    this.now = now;
    this.later = later;
    /** @type {{ value: Value } | null} */
    this.waiting = null;
    this.timed = false;
    this.last = Number.NEGATIVE_INFINITY;
  }

  /** @param {Value} value */
  offer(value) {
    this.waiting = { value };
    if (this.timed) return;
    const rest = this.last + this.interval - this.now();
    if (rest <= 0) this.flush();
    else this.wait(rest);
  }

  /** @param {number} milliseconds */
  wait(milliseconds) {
    this.timed = true;
    this.later(() => {
      this.timed = false;
      this.flush();
    }, milliseconds);
  }

  /** Send what waits, now. */
  flush() {
    if (!this.waiting) return;
    const { value } = this.waiting;
    this.waiting = null;
    this.last = this.now();
    this.send(value);
  }
}
