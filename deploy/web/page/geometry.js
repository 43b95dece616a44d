// Points, planes and rectangles of surfaces, in world coordinates [m].

/** @typedef {[number, number, number]} Vector */

export const minus = (/** @type {Vector} */ a, /** @type {Vector} */ b) =>
  /** @type {Vector} */ ([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
export const dot = (/** @type {Vector} */ a, /** @type {Vector} */ b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const times = (/** @type {Vector} */ a, /** @type {number} */ f) =>
  /** @type {Vector} */ ([a[0] * f, a[1] * f, a[2] * f]);
/** a + b f */
export const along = (/** @type {Vector} */ a, /** @type {Vector} */ b, /** @type {number} */ f) =>
  /** @type {Vector} */ ([a[0] + b[0] * f, a[1] + b[1] * f, a[2] + b[2] * f]);
export const length = (/** @type {Vector} */ a) => Math.hypot(...a);
const cross = (/** @type {Vector} */ a, /** @type {Vector} */ b) =>
  /** @type {Vector} */ ([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]);

/** A point of a surface. */
/** @typedef {{point: Vector, normal: Vector}} Place */

/**
 * The plane of a surface point, with axes along those of the world where possible: `u` to the right and `v` up, seen
 * from above for a floor, and from the front for a wall.
 * @param {Place} place
 */
export function frame({ point, normal }) {
  const n = times(normal, 1 / length(normal));
  // v is the world's z on walls, and its y on floors and ceilings.
  const up = /** @type {Vector} */ (Math.abs(n[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0]);
  const inPlane = along(up, n, -dot(up, n));
  const v = times(inPlane, 1 / length(inPlane));
  return { origin: point, u: cross(v, n), v, normal: n };
}

/** @typedef {ReturnType<typeof frame>} Frame */

/** The coordinates of a point in the plane, and its distance from the plane. */
export function inFrame(/** @type {Frame} */ f, /** @type {Vector} */ point) {
  const d = minus(point, f.origin);
  return { u: dot(d, f.u), v: dot(d, f.v), away: dot(d, f.normal) };
}

/** Whether a point lies in the plane of a surface point, within a thousandth of their distance. */
export function isInPlane(/** @type {Place} */ place, /** @type {Vector} */ point) {
  return Math.abs(inFrame(frame(place), point).away) <= 1e-3 * length(minus(point, place.point));
}

/** The point of the plane with these coordinates. */
export const inWorld = (/** @type {Frame} */ f, /** @type {number} */ u, /** @type {number} */ v) =>
  along(along(f.origin, f.u, u), f.v, v);

/**
 * A rectangle with two opposite corners on a surface, and the centres of its cells, row by row from the lowest v.
 * @param {Place} from the first corner, whose plane it is
 * @param {Vector} to a point over the opposite corner
 * @param {number} most cells along the longer side
 */
export function grid(from, to, most) {
  const plane = frame(from);
  const corner = inFrame(plane, to);
  const u0 = Math.min(0, corner.u),
    v0 = Math.min(0, corner.v);
  const width = Math.abs(corner.u),
    height = Math.abs(corner.v);
  const longer = Math.max(width, height);
  const cells = (/** @type {number} */ side) => Math.max(2, Math.round((most * side) / longer));
  const columns = cells(width),
    rows = cells(height);
  const points = [];
  for (let j = 0; j < rows; ++j)
    for (let i = 0; i < columns; ++i)
      points.push(inWorld(plane, u0 + ((i + 0.5) * width) / columns, v0 + ((j + 0.5) * height) / rows));
  return { plane, u0, v0, width, height, columns, rows, points };
}

/**
 * Points on the straight line from a surface point, in its plane, with both ends.
 * @param {Place} from
 * @param {Vector} to a point over the end
 * @param {number} n at least 2
 */
export function line(from, to, n) {
  const plane = frame(from);
  const end = inFrame(plane, to);
  const points = Array.from({ length: n }, (_, i) => inWorld(plane, (end.u * i) / (n - 1), (end.v * i) / (n - 1)));
  return { plane, length: Math.hypot(end.u, end.v), end, points };
}
