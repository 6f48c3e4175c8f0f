import assert from "node:assert/strict";
import { test } from "node:test";
import { drawCloud, rowAt, thereIn, wordsOnCloud } from "../../static/web/cloud.js";

const cloud = /** @type {import("../../static/web/messages.js").CloudShown} */ ({
  frames: { shape: [3], data: new Float32Array([0, 12, 24]) },
  places: { shape: [2, 2], data: new Float32Array([0, 0, 1, 1]) },
  weights: { shape: [3, 2], data: new Uint8Array([255, 250, 255, 5, 0, 255]) },
  entropy: { shape: [3], data: new Float32Array([1, 0.2, 0]) },
  modes: { shape: [2, 2], data: new Float32Array([0, 0, 1, 1]) },
  mass: { shape: [2], data: new Float32Array([0.75, 0.25]) },
  near: ["bow", "rest"],
  entries: 512,
});
const view = {
  extent: { left: 0, right: 1, bottom: 0, top: 1 },
  box: { left: 0, top: 0, width: 100, height: 100 },
};

test("what has been seen by a frame", () => {
  assert.deepEqual(
    [0, 11.9, 12, 23, 24, 900].map((frame) => rowAt(cloud, frame)),
    [0, 0, 1, 1, 2, 2],
  );
});

test("an empty cloud is none", () => {
  assert.equal(thereIn(null), null);
  assert.equal(thereIn({ ...cloud, places: { shape: [0, 2], data: new Float32Array(0) } }), null);
  assert.equal(thereIn(cloud), cloud);
});

/** Counts what is drawn. @param {number} row */
function drawn(row) {
  const calls = { points: 0, rings: 0 };
  const nothing = () => {};
  const context = /** @type {CanvasRenderingContext2D} */ (
    /** @type {unknown} */ ({
      fillRect: () => calls.points++,
      arc: () => calls.rings++,
      beginPath: nothing,
      stroke: nothing,
      strokeText: nothing,
      fillText: nothing,
      save: nothing,
      restore: nothing,
    })
  );
  const colors = /** @type {import("../../static/web/colors.js").Theme} */ ({});
  drawCloud(context, view, cloud, row, colors);
  return calls;
}

test("what hardly counts is not drawn, and what remains at the end has a ring", () => {
  assert.deepEqual(drawn(0), { points: 2, rings: 0 });
  assert.deepEqual(drawn(1), { points: 1, rings: 0 });
  assert.deepEqual(drawn(2), { points: 1, rings: 2 });
});

test("in words", () => {
  const words = wordsOnCloud(cloud, 0);
  assert.match(words, /after frame 0: spread over 2 of 512 motions/);
  assert.match(words, /75 % near bow, 25 % near rest/);
});
