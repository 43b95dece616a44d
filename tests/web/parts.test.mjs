// The parts of the page that compute: numbers as text, planes, scales, lines of equal value.
import assert from "node:assert/strict";
import test from "node:test";

import { colour, linearScale, logScale } from "../../deploy/web/page/colours.js";
import { joined, segments } from "../../deploy/web/page/contour.js";
import { count, digits, duration, metres, percent, withError } from "../../deploy/web/page/format.js";
import { dot, frame, grid, inFrame, isInPlane, length, line } from "../../deploy/web/page/geometry.js";

test("numbers have significant digits", () => {
  for (const [value, text] of [
    [0, "0"],
    [99.96, "100"],
    [0.01234, "0.0123"],
    [2.5, "2.50"],
    [-3, "−3.00"],
    [NaN, "–"],
    [1.5e9, "1.50e+9"],
  ])
    assert.equal(digits(value), text);
  assert.equal(duration(0.0123), "12.3 ms");
  assert.equal(duration(61.4), "61.4 s");
  assert.equal(duration(185), "3 min 5 s");
  assert.equal(count(12_345_678), "12.3 M");
  assert.equal(metres(-0.0001), "0.000");
  assert.equal(metres(-1.5), "−1.500");
  assert.equal(percent(0.0123), "1.2 %");
});

test("values have the decimals that their error supports", () => {
  assert.deepEqual(withError(86.2143, 1.3149), { value: "86.2", error: "1.3" });
  assert.deepEqual(withError(100.7, 0.0271), { value: "100.70", error: "0.03" });
  assert.deepEqual(withError(1234.5, 70), { value: "1235", error: "70" });
  assert.deepEqual(withError(0.00123, 0.00004), { value: "0.001230", error: "0.000040" });
  assert.deepEqual(withError(5, 0), { value: "5.00000", error: "0" });
});

test("the axes of a plane are at right angles, upright on walls, and along the world on floors", () => {
  for (const normal of [
    [0, 0, 1],
    [0, 0, -1],
    [0, -1, 0],
    [1, 0, 0],
    [0.6, 0, 0.8],
    [0.3, -0.5, 0.2],
  ]) {
    const f = frame({ point: [1, 2, 3], normal });
    for (const v of [f.u, f.v, f.normal]) assert.ok(Math.abs(length(v) - 1) < 1e-12);
    for (const [a, b] of [
      [f.u, f.v],
      [f.v, f.normal],
      [f.u, f.normal],
    ])
      assert.ok(Math.abs(dot(a, b)) < 1e-12);
    const { u, v, away } = inFrame(f, [1 + 2 * f.u[0] - f.v[0], 2 + 2 * f.u[1] - f.v[1], 3 + 2 * f.u[2] - f.v[2]]);
    assert.ok(Math.abs(u - 2) < 1e-12 && Math.abs(v + 1) < 1e-12 && Math.abs(away) < 1e-12);
  }
  assert.deepEqual(frame({ point: [0, 0, 0], normal: [0, 0, 1] }).u.map(Math.round), [1, 0, 0]);
  // Seen from the front, the right of a wall that faces -y is +x.
  const wall = frame({ point: [0, 0, 0], normal: [0, -1, 0] });
  assert.deepEqual(
    [wall.u, wall.v].map((v) => v.map((x) => Math.round(x) + 0)) /* no -0 */,
    [
      [1, 0, 0],
      [0, 0, 1],
    ],
  );
});

test("a grid has the centres of its cells, whichever corner comes first", () => {
  const corner = { point: [1, 2, 0], normal: [0, 0, 1] };
  const { columns, rows, points, width, height } = grid(corner, [5, 4, 0], 8);
  assert.deepEqual([columns, rows, width, height], [8, 4, 4, 2]);
  assert.deepEqual(points[0], [1.25, 2.25, 0]);
  assert.deepEqual(points.at(-1), [4.75, 3.75, 0]);
  assert.deepEqual(grid({ ...corner, point: [5, 4, 0] }, [1, 2, 0], 8).points, points);
  // A corner over the plane counts where it is in the plane.
  assert.deepEqual(grid(corner, [5, 4, 9], 8).points, points);
  assert.equal(isInPlane(corner, [5, 4, 0.001]), true);
  assert.equal(isInPlane(corner, [5, 4, 0.1]), false);
});

test("a line has both ends", () => {
  const { points, length: size } = line({ point: [0, 0, 1], normal: [0, 0, 1] }, [3, 4, 1], 6);
  assert.equal(size, 5);
  assert.deepEqual(points[0], [0, 0, 1]);
  points.at(-1).forEach((v, i) => assert.ok(Math.abs(v - [3, 4, 1][i]) < 1e-12));
});

test("scales have round ticks that contain the values", () => {
  assert.deepEqual(linearScale(3, 149).ticks, [0, 20, 40, 60, 80, 100, 120, 140, 160]);
  for (const [low, high] of [
    [0, 1],
    [90, 100],
    [0.001, 0.0023],
    [5, 1e6],
  ]) {
    const { ticks, share } = linearScale(low, high);
    assert.ok(ticks[0] <= low && ticks.at(-1) >= high * (1 - 1e-9), `${low} to ${high}: ${ticks}`);
    assert.equal(share(ticks[0]), 0);
    assert.ok(Math.abs(share(ticks.at(-1)) - 1) < 1e-9);
  }
  const { ticks, share } = logScale(0.9, 2000);
  assert.deepEqual(ticks, [1, 10, 100, 1000]);
  assert.ok(Math.abs(share(10) - share(1) - (share(100) - share(10))) < 1e-12);
  // Brightness rises along the colours, so that they can be told apart without their hue.
  const brightness = (s) => colour(s).reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  for (let i = 0; i < 20; ++i) assert.ok(brightness((i + 1) / 20) > brightness(i / 20), `at ${i / 20}`);
});

test("lines of equal value lie where the values cross, and join", () => {
  // A slope in x: the level 2.5 is the line x = 2.5.
  const slope = Array.from({ length: 5 * 4 }, (_, i) => i % 5);
  const [straight, ...none] = joined(segments(slope, 5, 4, 2.5));
  assert.equal(none.length, 0);
  assert.deepEqual(
    straight.map(([x]) => x),
    Array(4).fill(2.5),
  );
  assert.deepEqual(straight.map(([, y]) => y).sort(), [0, 1, 2, 3]);
  // A hill: one closed line about its top, which is at (4, 4).
  const hill = Array.from({ length: 81 }, (_, i) => 10 - Math.hypot((i % 9) - 4, Math.floor(i / 9) - 4));
  const rings = joined(segments(hill, 9, 9, 7.5));
  assert.equal(rings.length, 1);
  assert.deepEqual(
    rings[0][0].map((v) => v.toFixed(6)),
    rings[0].at(-1).map((v) => v.toFixed(6)),
  );
  for (const [x, y] of rings[0]) assert.ok(Math.abs(Math.hypot(x - 4, y - 4) - 2.5) < 0.1);
  // No line where a value is missing.
  assert.equal(segments([0, NaN, 1, 1], 2, 2, 0.5).length, 0);
  // A saddle: its mean decides which corners are joined.
  assert.equal(segments([1, 0, 0, 1], 2, 2, 0.6).length, 2);
  assert.equal(joined(segments([1, 0, 0, 1], 2, 2, 0.4)).length, 2);
});
