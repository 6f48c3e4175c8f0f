import assert from "node:assert/strict";
import { test } from "node:test";
import {
  closer,
  digitsOf,
  ellipseOf,
  formatted,
  magnification,
  moved,
  nearest,
  pointOf,
  ticks,
  toData,
  toPixel,
  withEqualUnits,
  within,
} from "../../static/web/scales.js";

const box = { left: 30, top: 10, width: 200, height: 100 };
const extent = { left: -2, right: 2, bottom: -1, top: 3 };
const view = { extent, box };

test("corners of the data are corners of the box, the second axis upwards", () => {
  assert.deepEqual(toPixel(view, [-2, 3]), [30, 10]);
  assert.deepEqual(toPixel(view, [2, -1]), [230, 110]);
  assert.deepEqual(toPixel(view, [0, 1]), [130, 60]);
});

test("a pixel's data has that pixel", () => {
  for (const pixel of /** @type {[number, number][]} */ ([
    [30, 10],
    [131, 47],
    [400, -20],
  ])) {
    const [x, y] = toPixel(view, toData(view, pixel));
    assert.ok(Math.abs(x - pixel[0]) < 1e-9 && Math.abs(y - pixel[1]) < 1e-9);
  }
});

test("equal units widen the shorter side and keep the middle", () => {
  assert.deepEqual(withEqualUnits(extent, box), { left: -4, right: 4, bottom: -1, top: 3 });
  assert.deepEqual(withEqualUnits(extent, { ...box, width: 50 }), {
    left: -2,
    right: 2,
    bottom: -3,
    top: 5,
  });
});

test("zooming leaves the point under the pointer where it is", () => {
  const about = toData(view, [80, 30]);
  const nearer = { extent: closer(extent, 2.5, about), box };
  const [x, y] = toPixel(nearer, about);
  assert.ok(Math.abs(x - 80) < 1e-9 && Math.abs(y - 30) < 1e-9);
  assert.equal(magnification(nearer.extent, extent), 2.5);
});

test("moved and within", () => {
  assert.deepEqual(moved(extent, 1, -1), { left: -1, right: 3, bottom: -2, top: 2 });
  assert.deepEqual(within(extent, [5, -4]), [2, -1]);
  assert.deepEqual(pointOf([1, 2, 3, 4], 1), [3, 4]);
});

test("ticks are round and within", () => {
  assert.deepEqual(ticks(-2.1, 2.1, 4), [-2, -1, 0, 1, 2]);
  assert.deepEqual(
    ticks(0.13, 0.31, 4).map((v) => formatted(v)),
    ["0.15", "0.20", "0.25", "0.30"],
  );
  assert.deepEqual(ticks(1, 1, 4), []);
  assert.deepEqual(ticks(Number.NaN, 1, 4), []);
});

test("as many digits as tell ticks apart", () => {
  assert.equal(digitsOf([0, 5]), 0);
  assert.equal(digitsOf([0, 0.5]), 1);
  assert.equal(digitsOf([0.15, 0.2]), 2);
});

test("a minus sign, and none before a zero", () => {
  assert.equal(formatted(-1.5), "−1.50");
  assert.equal(formatted(-0.001), "0.00");
});

test("the nearest point within reach", () => {
  const points = Float32Array.from([-2, 3, 0, 1, 0.1, 1]);
  assert.equal(nearest(view, points, [131, 60], 12), 1);
  assert.equal(nearest(view, points, [134, 60], 12), 2);
  assert.equal(nearest(view, points, [80, 100], 12), -1);
});

test("the ellipse of a covariance", () => {
  const straight = ellipseOf([4, 0, 0, 1]);
  assert.deepEqual([straight.major, straight.minor, straight.angle], [2, 1, 0]);
  const turned = ellipseOf([2.5, 1.5, 1.5, 2.5]); // axes 2 and 1, turned by 45 degrees
  assert.ok(Math.abs(turned.angle - Math.PI / 4) < 1e-12);
  assert.ok(Math.abs(turned.major - 2) < 1e-12 && Math.abs(turned.minor - 1) < 1e-12);
});
