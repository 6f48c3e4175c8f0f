import assert from "node:assert/strict";
import { test } from "node:test";
import { between, cellAt, contour, interpolated, maximum } from "../../static/web/grid.js";

// value = x + 10 y on an uneven grid
const grid = { x: [0, 1, 3], y: [0, 2], values: [0, 1, 3, 20, 21, 23] };

test("between centres", () => {
  assert.deepEqual(between([0, 1, 3], -1), [0, 0]);
  assert.deepEqual(between([0, 1, 3], 2), [1, 0.5]);
  assert.deepEqual(between([0, 1, 3], 9), [1, 1]);
  assert.deepEqual(between([5], 9), [0, 0]);
});

test("a plane is interpolated exactly, and constant beyond the centres", () => {
  assert.equal(interpolated(grid, 2, 1), 12);
  assert.equal(interpolated(grid, 0.25, 0.5), 5.25);
  assert.equal(interpolated(grid, 9, 9), 23);
});

test("one row is a line", () => {
  const line = { x: [0, 1], y: [0], values: [4, 6] };
  assert.equal(interpolated(line, 0.5, 7), 5);
  assert.deepEqual(cellAt(line, 0.9, 7), [0, 1]);
});

test("the cell with the nearest centre", () => {
  assert.deepEqual(cellAt(grid, 0.4, 0.9), [0, 0]);
  assert.deepEqual(cellAt(grid, 2.1, 1.1), [1, 2]);
  assert.deepEqual(cellAt(grid, -5, 50), [1, 0]);
});

test("the greatest value", () => {
  assert.equal(maximum([-3, -1, -2]), -1);
});

test("a contour lies where the bilinear grid has the value", () => {
  const x = Array.from({ length: 9 }, (_, i) => i - 4);
  const values = x.flatMap((b) => x.map((a) => -Math.hypot(a, b)));
  const pieces = contour({ x, y: x, values }, -2.5);
  assert.equal(pieces.length % 4, 0);
  assert.ok(pieces.length > 0);
  for (let i = 0; i < pieces.length; i += 2) {
    assert.ok(Math.abs(interpolated({ x, y: x, values }, pieces[i], pieces[i + 1]) + 2.5) < 1e-9);
  }
});

test("a contour round one high cell is closed", () => {
  const pieces = contour({ x: [0, 1, 2], y: [0, 1, 2], values: [0, 0, 0, 0, 1, 0, 0, 0, 0] }, 0.5);
  const ends = new Map();
  for (let i = 0; i < pieces.length; i += 2) {
    const end = `${pieces[i]},${pieces[i + 1]}`;
    ends.set(end, (ends.get(end) ?? 0) + 1);
  }
  assert.deepEqual(new Set(ends.keys()), new Set(["0.5,1", "1,0.5", "1.5,1", "1,1.5"]));
  assert.ok([...ends.values()].every((times) => times === 2));
});

test("a saddle joins the corners that its middle is on the side of", () => {
  const corners = (/** @type {number} */ high) =>
    contour({ x: [0, 1], y: [0, 1], values: [high, 0, 0, high] }, 0.5);
  const low = corners(0.9); // the middle, 0.45, is below: lines cut the high corners off
  const high = corners(2); // the middle, 1, is above: lines cut the low corners off
  const apart = (/** @type {number[]} */ [x0, y0, x1, y1]) => x0 + y0 + x1 + y1;
  assert.ok(apart(low) < 1.2 || apart(low) > 2.8);
  assert.ok(Math.abs(apart(high) - 2) < 0.8);
});

test("no contour above everything", () => {
  assert.deepEqual(contour(grid, 100), []);
});
