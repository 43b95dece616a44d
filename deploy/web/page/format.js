// Numbers as people read them.

/** Rounds to significant digits, without an exponent in the range of daily use. */
export function digits(/** @type {number} */ value, significant = 3) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-4) return value.toExponential(significant - 1);
  // Rounding may add a digit before the point.
  const rounded = Number(value.toPrecision(significant));
  const decimals = Math.max(0, significant - 1 - Math.floor(Math.log10(Math.abs(rounded))));
  return rounded.toFixed(Math.min(decimals, 8)).replace("-", "−");
}

/** A value with as many decimals as its error supports: two digits of the error, and at most four of the value. */
export function withError(/** @type {number} */ value, /** @type {number} */ error) {
  if (!(error > 0)) return { value: digits(value, 6), error: "0" };
  const first = (/** @type {number} */ v) => -Math.floor(Math.log10(Math.abs(v)));
  const supported = 1 + first(error),
    readable = value === 0 ? supported : Math.max(3 + first(value), first(error));
  const decimals = Math.min(8, Math.max(0, Math.min(supported, readable)));
  return { value: value.toFixed(decimals).replace("-", "−"), error: error.toFixed(decimals) };
}

/** A unit, for readers of the screen. */
export const spoken = (/** @type {string} */ unit) => (unit === "lx" ? "lux" : unit);

/** A time [s]. */
export function duration(/** @type {number} */ seconds) {
  if (seconds < 1e-3) return `${digits(seconds * 1e6, 2)} µs`;
  if (seconds < 1) return `${digits(seconds * 1e3, 3)} ms`;
  if (seconds < 120) return `${digits(seconds, 3)} s`;
  return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

/** A count. */
export function count(/** @type {number} */ n) {
  if (n >= 9.995e8) return `${digits(n / 1e9)} G`;
  if (n >= 9.995e5) return `${digits(n / 1e6)} M`;
  if (n >= 9995) return `${digits(n / 1e3)} k`;
  return String(n);
}

/** A length or a coordinate [m], to the millimetre. */
export function metres(/** @type {number} */ value) {
  const text = Math.abs(value) >= 1e5 ? value.toExponential(4) : value.toFixed(3);
  return (Number(text) === 0 ? "0.000" : text).replace("-", "−");
}

/** A share as a percentage. */
export function percent(/** @type {number} */ share) {
  return `${digits(share * 100, share < 0.1 ? 2 : 3)} %`;
}
