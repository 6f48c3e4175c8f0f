/**
 * From data to pixels and back: a window of the data in a box on the screen, ticks, zoom, hit tests.
 * Pure functions; data has its second axis upwards, pixels have theirs downwards.
 */

/** @typedef {{ left: number, right: number, bottom: number, top: number }} Extent in data units */
/** @typedef {{ left: number, top: number, width: number, height: number }} Box in CSS pixels */
/** @typedef {{ extent: Extent, box: Box }} View */
/** @typedef {[number, number]} Point */

/** @type {(value: number, low: number, high: number) => number} */
export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/** The i-th of many points. @type {(data: ArrayLike<number>, i?: number) => Point} */
export const pointOf = (data, i = 0) => [data[2 * i], data[2 * i + 1]];

/** Where a point of the data lies on the screen. @type {(view: View, point: Point) => Point} */
export function toPixel({ extent, box }, [x, y]) {
  return [
    box.left + ((x - extent.left) / (extent.right - extent.left)) * box.width,
    box.top + ((extent.top - y) / (extent.top - extent.bottom)) * box.height,
  ];
}

/** What point of the data lies there on the screen. @type {(view: View, pixel: Point) => Point} */
export function toData({ extent, box }, [px, py]) {
  return [
    extent.left + ((px - box.left) / box.width) * (extent.right - extent.left),
    extent.top - ((py - box.top) / box.height) * (extent.top - extent.bottom),
  ];
}

/**
 * The smallest extent around this one whose units are equally long along both axes.
 * @type {(extent: Extent, box: Box) => Extent}
 */
export function withEqualUnits(extent, box) {
  const width = extent.right - extent.left;
  const height = extent.top - extent.bottom;
  const unit = Math.max(width / box.width, height / box.height);
  const x = (extent.left + extent.right) / 2;
  const y = (extent.bottom + extent.top) / 2;
  return {
    left: x - (unit * box.width) / 2,
    right: x + (unit * box.width) / 2,
    bottom: y - (unit * box.height) / 2,
    top: y + (unit * box.height) / 2,
  };
}

/**
 * The extent seen `factor` times closer, with the point `about` where it is on the screen.
 * @type {(extent: Extent, factor: number, about: Point) => Extent}
 */
export function closer(extent, factor, [x, y]) {
  return {
    left: x + (extent.left - x) / factor,
    right: x + (extent.right - x) / factor,
    bottom: y + (extent.bottom - y) / factor,
    top: y + (extent.top - y) / factor,
  };
}

/** @type {(extent: Extent, dx: number, dy: number) => Extent} */
export const moved = ({ left, right, bottom, top }, dx, dy) => ({
  left: left + dx,
  right: right + dx,
  bottom: bottom + dy,
  top: top + dy,
});

/** How many times closer `extent` is than `home`. @type {(extent: Extent, home: Extent) => number} */
export const magnification = (extent, home) =>
  (home.right - home.left) / (extent.right - extent.left);

/** The nearest point of an extent. @type {(extent: Extent, point: Point) => Point} */
export const within = (extent, [x, y]) => [
  clamp(x, extent.left, extent.right),
  clamp(y, extent.bottom, extent.top),
];

/**
 * Round numbers within [low, high], about `count` of them.
 * @type {(low: number, high: number, count: number) => number[]}
 */
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  if (!(rough > 0) || !Number.isFinite(rough)) return [];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.75) ?? power * 10;
  const result = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++) {
    result.push(i * step);
  }
  return result;
}

/**
 * A number as it stands on an axis or in a read-out, with a minus sign that is as wide as a plus.
 * @type {(value: number, digits?: number) => string}
 */
export function formatted(value, digits = 2) {
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Digits that tell two neighbouring ticks apart. @type {(values: number[]) => number} */
export function digitsOf(values) {
  if (values.length < 2) return 1;
  const step = Math.abs(values[1] - values[0]);
  return clamp(Math.ceil(-Math.log10(step) - 1e-6), 0, 6);
}

/**
 * The point nearest to a pixel, -1 where none is within `reach` pixels.
 * @type {(view: View, points: ArrayLike<number>, pixel: Point, reach: number) => number}
 */
export function nearest(view, points, [px, py], reach) {
  let found = -1;
  let least = reach * reach;
  for (let i = 0; 2 * i + 1 < points.length; i++) {
    const [x, y] = toPixel(view, [points[2 * i], points[2 * i + 1]]);
    const apart = (x - px) ** 2 + (y - py) ** 2;
    if (apart <= least) {
      least = apart;
      found = i;
    }
  }
  return found;
}

/**
 * Half axes and angle (radians, from the first axis towards the second) of a covariance's ellipse.
 * @type {(covariance: ArrayLike<number>) => { major: number, minor: number, angle: number }}
 */
export function ellipseOf(covariance) {
  const [a, b, , d] = [covariance[0], covariance[1], covariance[2], covariance[3]];
  const middle = (a + d) / 2;
  const apart = Math.hypot((a - d) / 2, b);
  return {
    major: Math.sqrt(Math.max(middle + apart, 0)),
    minor: Math.sqrt(Math.max(middle - apart, 0)),
    angle: Math.atan2(2 * b, a - d) / 2,
  };
}
