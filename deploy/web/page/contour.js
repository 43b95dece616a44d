// Lines of equal value on a grid.

/** @typedef {[number, number]} Position column and row of a grid, from 0 to its last */

/**
 * The line of one level as segments, by marching squares.  Squares with a missing corner have none.
 * @param {ArrayLike<number>} values row by row; NaN: missing
 * @param {number} columns
 * @param {number} rows
 * @param {number} level
 * @returns {[Position, Position][]}
 */
export function segments(values, columns, rows, level) {
  /** @type {[Position, Position][]} */
  const result = [];
  for (let j = 0; j + 1 < rows; ++j)
    for (let i = 0; i + 1 < columns; ++i) {
      // The corners in turn about the square, and where the level crosses the sides between them.
      const corners = /** @type {Position[]} */ ([
        [i, j],
        [i + 1, j],
        [i + 1, j + 1],
        [i, j + 1],
      ]);
      const at = corners.map(([x, y]) => values[y * columns + x]);
      if (at.some(Number.isNaN)) continue;
      /** @type {Position[]} */
      const crossings = [];
      for (let k = 0; k < 4; ++k) {
        const a = at[k],
          b = at[(k + 1) % 4];
        if (a >= level === b >= level) continue;
        const t = (level - a) / (b - a);
        const [from, to] = [corners[k], corners[(k + 1) % 4]];
        crossings.push([from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t]);
      }
      if (crossings.length === 2) result.push([crossings[0], crossings[1]]);
      if (crossings.length !== 4) continue;
      // A saddle: the mean tells which corners belong together.
      const joined = at.reduce((sum, v) => sum + v, 0) / 4 >= level === at[0] >= level;
      const [p, q, r, s] = crossings;
      result.push(
        ...(joined
          ? /** @type {[Position, Position][]} */ ([
              [p, q],
              [r, s],
            ])
          : /** @type {[Position, Position][]} */ ([
              [s, p],
              [q, r],
            ])),
      );
    }
  return result;
}

/**
 * Joins segments to lines, each a list of positions.
 * @param {[Position, Position][]} parts
 */
export function joined(parts) {
  const key = (/** @type {Position} */ p) => `${p[0].toFixed(6)},${p[1].toFixed(6)}`;
  /** @type {Map<string, number[]>} */
  const ends = new Map();
  parts.forEach((part, i) => part.forEach((p) => ends.set(key(p), [...(ends.get(key(p)) ?? []), i])));
  const used = new Set();
  /** @type {Position[][]} */
  const lines = [];
  parts.forEach((part, start) => {
    if (used.has(start)) return;
    used.add(start);
    const line = [...part];
    for (const atEnd of [true, false])
      for (;;) {
        const tip = atEnd ? line[line.length - 1] : line[0];
        const next = ends.get(key(tip))?.find((i) => !used.has(i));
        if (next === undefined) break;
        used.add(next);
        const other = key(parts[next][0]) === key(tip) ? parts[next][1] : parts[next][0];
        if (atEnd) line.push(other);
        else line.unshift(other);
      }
    lines.push(line);
  });
  return lines;
}
