// False colours, their scale and their legend.

// Stops of a map with rising lightness, also for people who see red and green alike: near viridis and its bright end.
const stops = [
  [38, 18, 66],
  [62, 40, 120],
  [52, 92, 141],
  [34, 132, 141],
  [46, 168, 126],
  [116, 204, 84],
  [197, 222, 52],
  [253, 240, 110],
];

/** The colour of a share from 0 to 1, as [r, g, b] of 0 to 255. */
export function colour(/** @type {number} */ share) {
  const at = Math.min(1, Math.max(0, share || 0)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(at));
  return stops[i].map((low, k) => Math.round(low + (stops[i + 1][k] - low) * (at - i)));
}

export const css = (/** @type {number} */ share) => `rgb(${colour(share).join(" ")})`;

/** The least of 1, 2, 2.5 and 5 times a power of ten that is not below `value`. */
function roundUp(/** @type {number} */ value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const factor = [1, 2, 2.5, 5, 10].find((f) => f * power >= value * (1 - 1e-9)) ?? 10;
  return factor * power;
}

/**
 * A scale of numbers: the share of each value, and round ticks.
 * @typedef {{share: (value: number) => number, ticks: number[], low: number, high: number}} Scale
 */

/**
 * From 0 or a round number below `low` to one above `high`.
 * @returns {Scale}
 */
export function linearScale(/** @type {number} */ low, /** @type {number} */ high, steps = 8) {
  if (!(high > 0)) return { share: () => 0, ticks: [0], low: 0, high: 1 };
  // A scale from 0, unless the values differ by less than half.
  const start = low > high / 2 ? low : 0;
  const step = roundUp(Math.max((high - start) / steps, high * 1e-6));
  const first = Math.floor(start / step) * step,
    last = Math.ceil(high / step - 1e-9) * step;
  const ticks = [];
  for (let i = 0; first + i * step <= last + step / 2; ++i) ticks.push(Number((first + i * step).toPrecision(12)));
  return { share: (v) => (v - first) / (last - first || 1), ticks, low: first, high: last };
}

/**
 * Decades, for values that span several of them.
 * @returns {Scale}
 */
export function logScale(/** @type {number} */ low, /** @type {number} */ high) {
  if (!(high > 0)) return { share: () => 0, ticks: [], low: 0, high: 1 };
  const bottom = Math.max(low, high * 1e-5);
  const a = Math.log10(bottom),
    b = Math.max(Math.log10(high), a + 0.3);
  const ticks = [];
  for (let decade = Math.floor(a); decade <= Math.ceil(b); ++decade)
    for (const factor of b - a > 2.5 ? [1] : [1, 2, 5]) {
      const tick = Number((factor * 10 ** decade).toPrecision(12));
      if (Math.log10(tick) >= a - 1e-9 && Math.log10(tick) <= b + 1e-9) ticks.push(tick);
    }
  return { share: (v) => (Math.log10(v) - a) / (b - a), ticks, low: bottom, high: 10 ** b };
}
