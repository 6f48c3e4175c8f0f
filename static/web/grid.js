/**
 * The landscape as numbers: what stands between its cells, the cell at a point, lines of equal value.
 * A grid has its rows along the second axis, ascending, and its columns along the first.
 */

/**
 * @typedef {object} Grid
 * @property {ArrayLike<number>} values rows * columns of them
 * @property {ArrayLike<number>} x centre of each column, ascending
 * @property {ArrayLike<number>} y centre of each row, ascending
 */

/**
 * Index and share of the way to the next of where a value lies among ascending centres.
 * @type {(centres: ArrayLike<number>, value: number) => [number, number]}
 */
export function between(centres, value) {
  const last = centres.length - 1;
  if (last < 1 || value <= centres[0]) return [0, 0];
  if (value >= centres[last]) return [last - 1, 1];
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (centres[middle] <= value) low = middle;
    else high = middle;
  }
  return [low, (value - centres[low]) / (centres[high] - centres[low])];
}

/** Bilinear between centres, constant beyond them. @type {(grid: Grid, x: number, y: number) => number} */
export function interpolated({ values, x: xs, y: ys }, x, y) {
  const columns = xs.length;
  const [column, u] = between(xs, x);
  const [row, v] = between(ys, y);
  const right = Math.min(column + 1, columns - 1);
  const above = Math.min(row + 1, ys.length - 1);
  const low = values[row * columns + column] * (1 - u) + values[row * columns + right] * u;
  const high = values[above * columns + column] * (1 - u) + values[above * columns + right] * u;
  return low * (1 - v) + high * v;
}

/** Row and column of the cell with the nearest centre. @type {(grid: Grid, x: number, y: number) => [number, number]} */
export function cellAt({ x: xs, y: ys }, x, y) {
  const [column, u] = between(xs, x);
  const [row, v] = between(ys, y);
  return [row + (v > 0.5 ? 1 : 0), column + (u > 0.5 ? 1 : 0)];
}

/** @type {(values: ArrayLike<number>) => number} */
export function maximum(values) {
  let most = Number.NEGATIVE_INFINITY;
  for (let i = 0; i < values.length; i++) if (values[i] > most) most = values[i];
  return most;
}

// Marching squares: for each combination of corners above the level (1 lower left, 2 lower right,
// 4 upper right, 8 upper left), which edges (0 lower, 1 right, 2 upper, 3 left) a line joins.
/** @type {number[][]} */
const JOINED = [
	[], [3, 0], [0, 1], [3, 1], [1, 2], [3, 0, 1, 2], [0, 2], [3, 2],
	[2, 3], [2, 0], [0, 1, 2, 3], [2, 1], [1, 3], [1, 0], [0, 3], [],
]; // biome-ignore format: a table

/**
 * Where the grid, bilinear between its centres, has a value: pieces x0, y0, x1, y1, one after the
 * other. In a saddle the middle's mean decides which corners belong together.
 * @type {(grid: Grid, level: number) => number[]}
 */
export function contour({ values, x, y }, level) {
  const columns = x.length;
  /** @type {number[]} */
  const pieces = [];
  for (let row = 0; row + 1 < y.length; row++) {
    for (let column = 0; column + 1 < columns; column++) {
      const i = row * columns + column;
      const corners = [values[i], values[i + 1], values[i + columns + 1], values[i + columns]];
      let which = 0;
      for (let k = 0; k < 4; k++) if (corners[k] > level) which |= 1 << k;
      if (which === 5 || which === 10) {
        const middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
        if (middle > level) which = 15 - which;
      }
      for (const edge of JOINED[which]) {
        const from = corners[edge];
        const share = (level - from) / (corners[(edge + 1) % 4] - from);
        const along = edge < 2 ? share : 1 - share;
        const u = edge % 2 === 0 ? along : edge === 1 ? 1 : 0;
        const v = edge % 2 === 1 ? along : edge === 2 ? 1 : 0;
        pieces.push(x[column] + u * (x[column + 1] - x[column]));
        pieces.push(y[row] + v * (y[row + 1] - y[row]));
      }
    }
  }
  return pieces;
}
