/** Which names have room beside their points, and where. Pure. */

/** @typedef {import("./scales.js").Box} Box */

const GAP = 3; // pixels between a mark and its name

/** @type {(a: Box, b: Box) => boolean} */
const overlap = (a, b) =>
  a.left < b.left + b.width &&
  b.left < a.left + a.width &&
  a.top < b.top + b.height &&
  b.top < a.top + a.height;

/** @type {(inner: Box, outer: Box) => boolean} */
const inside = (inner, outer) =>
  inner.left >= outer.left &&
  inner.top >= outer.top &&
  inner.left + inner.width <= outer.left + outer.width &&
  inner.top + inner.height <= outer.top + outer.height;

/** @type {(x: number, y: number, radius: number, width: number, height: number) => Box[]} */
const candidates = (x, y, radius, width, height) => {
  const side = radius + GAP;
  return [
    [x + side, y - height / 2],
    [x - side - width, y - height / 2],
    [x - width / 2, y - side - height],
    [x - width / 2, y + side],
    [x + side * 0.7, y - side * 0.7 - height],
    [x + side * 0.7, y + side * 0.7],
  ].map(([left, top]) => ({ left, top, width, height }));
};

/**
 * Greedy, in the order given (so the most important first): a name is placed where it covers no
 * mark and no name that has its place already, or left out.
 *
 * @param {{ x: number, y: number, radius: number, width: number }[]} marks
 * @param {number} height of a line of text
 * @param {Box} area that a name may not leave
 * @returns {(Box | null)[]}
 */
export function placed(marks, height, area) {
  /** @type {Box[]} */
  const taken = marks.map(({ x, y, radius }) => ({
    left: x - radius,
    top: y - radius,
    width: 2 * radius,
    height: 2 * radius,
  }));
  return marks.map(({ x, y, radius, width }) => {
    const free = candidates(x, y, radius, width, height).find(
      (box) => inside(box, area) && !taken.some((other) => overlap(box, other)),
    );
    if (free) taken.push(free);
    return free ?? null;
  });
}
