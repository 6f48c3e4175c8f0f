import assert from "node:assert/strict";
import { test } from "node:test";
import { classMark, css, rgb } from "../../static/web/colors.js";
import { rangeOf } from "../../static/web/curves.js";
import { placed } from "../../static/web/labels.js";

test("correlation: red -1, white 0, blue 1, grey for none", () => {
  const [red, white, blue] = [-1, 0, 1].map((value) => rgb("correlation", (value + 1) / 2));
  assert.ok(red[0] > 2 * red[2] && blue[2] > 2 * blue[0]);
  assert.deepEqual(white, [247, 247, 247]);
  assert.deepEqual(rgb("correlation", 7), blue);
  assert.equal(new Set(rgb("correlation", Number.NaN).map((c) => Math.round(c / 20))).size, 1);
  assert.match(css("valence", 0.5), /^rgb\(\d+ \d+ \d+\)$/);
});

test("33 classes look different, by colour or by shape", () => {
  const looks = Array.from({ length: 33 }, (_, k) => classMark(k));
  assert.equal(new Set(looks.map(({ color, shape }) => color + shape)).size, 33);
});

const area = { left: 0, top: 0, width: 100, height: 60 };
test("names neither leave the area nor cover marks and one another", () => {
  const marks = [
    { x: 20, y: 30, radius: 5, width: 40 },
    { x: 80, y: 30, radius: 5, width: 40 },
    { x: 21, y: 31, radius: 5, width: 300 },
  ];
  const [first, second, third] = placed(marks, 12, area);
  assert.ok(first && first.left > 25);
  assert.ok(second && second.left + 40 <= 100 && second.top + 12 <= 60);
  assert.ok(
    first &&
      second &&
      (first.left + 40 <= second.left ||
        first.top + 12 <= second.top ||
        second.top + 12 <= first.top),
  );
  assert.equal(third, null);
});

test("the first in order has its name first", () => {
  const marks = [10, 14].map((x) => ({ x, y: 30, radius: 2, width: 80 }));
  const tight = { left: 0, top: 24, width: 110, height: 12 };
  assert.deepEqual(placed(marks, 12, tight).map(Boolean), [false, true]);
  assert.deepEqual(placed(marks.reverse(), 12, tight).map(Boolean), [true, false]);
});

const curves = {
  angles: Float32Array.from([0, 5, 1, 5]),
  reference: Float32Array.from([-1, 5]),
  low: null,
  high: Float32Array.from([3, 9]),
  columns: 2,
  joint: 0,
  frames: 2,
  fps: 25,
};
test("curves fill the height with all that is drawn of a joint", () => {
  const { bottom, top } = rangeOf(curves);
  assert.ok(bottom < -1 && bottom > -1.5 && top > 3 && top < 3.5);
});

test("a joint at rest is not blown up", () => {
  const { bottom, top } = rangeOf({ ...curves, joint: 1, high: null });
  assert.deepEqual(
    [bottom, top].map((v) => v.toFixed(2)),
    ["4.90", "5.10"],
  );
});
