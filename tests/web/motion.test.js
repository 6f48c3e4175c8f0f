import assert from "node:assert/strict";
import { test } from "node:test";
import {
  advanced,
  envelope,
  refitted,
  rotated,
  sampled,
  started,
  turned,
} from "../../static/web/motion.js";

const clock = { frame: 10, frames: 101, fps: 25, speed: 1, loop: true, playing: true };

test("a clock that plays goes on by its rate and speed", () => {
  assert.equal(advanced(clock, 0.4).frame, 20);
  assert.equal(advanced({ ...clock, speed: 0.5 }, 0.4).frame, 15);
  assert.equal(advanced({ ...clock, playing: false }, 0.4).frame, 10);
  assert.equal(advanced(clock, -1).frame, 10);
});

test("at the end it goes round, or stops", () => {
  assert.equal(advanced(clock, 4).frame, 10);
  const ended = advanced({ ...clock, loop: false }, 60);
  assert.equal(ended.frame, 100);
  assert.equal(ended.playing, false);
});

test("played again from the start where it stands at the end", () => {
  assert.equal(started({ ...clock, frame: 100 }).frame, 0);
  assert.equal(started(clock).frame, 10);
});

test("another motion keeps the phase", () => {
  assert.equal(refitted(clock, 200, 25).frame, 10);
  assert.equal(refitted({ ...clock, frame: 90 }, 51, 25).frame, 40);
  assert.equal(refitted({ ...clock, frame: 90, loop: false }, 51, 25).frame, 50);
  assert.equal(refitted(clock, 1, 25).frame, 0);
});

test("between two frames the angles are between", () => {
  const angles = Float32Array.from([0, 10, 1, 20, 4, 0]);
  const out = new Float32Array(2);
  sampled(angles, 2, 0.5, out);
  assert.deepEqual([...out], [0.5, 15]);
  sampled(angles, 2, 99, out);
  assert.deepEqual([...out], [4, 0]);
});

test("a joint turns about its axis after its rest", () => {
  const c = Math.SQRT1_2;
  const close = (/** @type {number[]} */ a, /** @type {number[]} */ b) =>
    a.forEach((value, i) => {
      assert.ok(Math.abs(value - b[i]) < 1e-9, `${a} is not ${b}`);
    });
  close(turned([1, 0, 0, 0], [0, 0, 1], 0, Math.PI / 2), [0, 0, c, c]);
  // rest: a quarter turn about x; then one about the new z: (c, c, 0, 0) * (c, 0, 0, c)
  close(
    turned([9, 9, 9, 9, c, c, 0, 0], [9, 9, 9, 0, 0, 1], 1, Math.PI / 2),
    [0.5, -0.5, 0.5, 0.5],
  );
  close(rotated([c, c, 0, 0], [0, 1, 0], 0), [0, 0, 1]);
});

test("the band of some motions", () => {
  const { low, high } = envelope(Float32Array.from([1, 5, 2, 3]), 2);
  assert.deepEqual([...low], [1, 3]);
  assert.deepEqual([...high], [2, 5]);
});
