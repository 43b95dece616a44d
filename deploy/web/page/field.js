// The illuminance along a line and on a grid of a surface.
import { lighting } from "./api.js";
import { colour, css, linearScale } from "./colours.js";
import { joined, segments } from "./contour.js";
import { draw, make } from "./dom.js";
import { count, digits, duration, spoken, withError } from "./format.js";
import { inFrame } from "./geometry.js";
import { floorLx } from "./point.js";

/** @typedef {import("./geometry.js").Vector} Vector */
/** @typedef {ReturnType<typeof import("./geometry.js").grid>} Grid */
/** @typedef {ReturnType<typeof import("./geometry.js").line>} Line */

const insideSolid = 8;
/** Points of one call: enough for all threads, and soon answered. */
const pointsAtOnce = 128;
/** Samples of a point in the first pass. */
const coarseSamples = 32;
/** Most samples of a point in the second pass: one dark corner must not keep the map waiting. */
const mostSamples = 16384;

/**
 * The light at many points of a plane.  NaN: not yet known, or inside a solid.
 * @typedef {{lux: Float64Array, lower: Float64Array, upper: Float64Array, done: number, seconds: number,
 *   samples: number, rays: number}} Field
 */

/**
 * Asks for the illuminance at points with one normal, in parts.  Calls `progress` after each.  A first pass with few
 * samples shows the field soon.  Its mean is the measure of the second pass: where it is darker, errors need not be
 * smaller than at the mean.
 * @param {string} sceneId
 * @param {Vector[]} points
 * @param {Vector} normal
 * @param {number} relative
 * @param {AbortSignal} signal
 * @param {(field: Field) => void} progress
 */
export async function measureField(sceneId, points, normal, relative, signal, progress) {
  const fresh = () => new Float64Array(points.length).fill(NaN);
  /** @type {Field} */
  const field = { lux: fresh(), lower: fresh(), upper: fresh(), done: 0, seconds: 0, samples: 0, rays: 0 };
  /** @type {Stop} */
  const coarse = { case: "samples", value: coarseSamples };
  await pass(sceneId, points, normal, coarse, signal, field, progress);
  const absoluteFloor = Math.max(floorLx, relative * (summary(field).mean || 0));
  /** @type {Stop} */
  const fine = { case: "targetError", value: { relative, absoluteFloor, maxSamples: mostSamples } };
  await pass(sceneId, points, normal, fine, signal, field, progress);
  return field;
}

/** @typedef {typeof import("../../generated/lucerna/v1/accuracy_pb.js").AccuracySchema} Schema */
/** @typedef {NonNullable<import("@bufbuild/protobuf").MessageInitShape<Schema>["stop"]>} Stop */

/**
 * Measures all points once.
 * @param {string} sceneId
 * @param {Vector[]} points
 * @param {Vector} normal
 * @param {Stop} stop
 * @param {AbortSignal} signal
 * @param {Field} field
 * @param {(field: Field) => void} progress
 */
async function pass(sceneId, points, normal, stop, signal, field, progress) {
  const [x, y, z] = points[0];
  for (let from = 0; from < points.length; from += pointsAtOnce) {
    const part = points.slice(from, from + pointsAtOnce);
    const answer = await lighting.estimateIrradiance(
      {
        sceneId,
        receivers: { originM: { x, y, z }, offsetsM: part.flatMap((p) => [p[0] - x, p[1] - y, p[2] - z]) },
        normals: part.flatMap(() => normal),
        seed: { seed: 0n, firstItem: BigInt(from) },
        accuracy: { stop },
      },
      { signal },
    );
    part.forEach((_, i) => {
      const isKnown = answer.status[i] !== insideSolid;
      field.lux[from + i] = isKnown ? answer.illuminanceLx[i] : NaN;
      field.lower[from + i] = isKnown ? answer.lowerLx[i] : NaN;
      field.upper[from + i] = isKnown ? answer.upperLx[i] : NaN;
    });
    field.done = Math.max(field.done, from + part.length);
    field.seconds += answer.cost?.wallTimeS ?? 0;
    field.samples += Number(answer.cost?.samples ?? 0n);
    field.rays += Number((answer.cost?.shadowRays ?? 0n) + (answer.cost?.indirectRays ?? 0n));
    progress(field);
  }
}

/** Minimum, mean and maximum of the known values; the error of the mean, whose points err independently. */
export function summary(/** @type {Field} */ { lux, lower, upper }) {
  let n = 0,
    sum = 0,
    squares = 0,
    low = Infinity,
    high = 0;
  for (let i = 0; i < lux.length; ++i) {
    if (Number.isNaN(lux[i])) continue;
    n += 1;
    sum += lux[i];
    squares += ((upper[i] - lower[i]) / 2) ** 2;
    low = Math.min(low, lux[i]);
    high = Math.max(high, lux[i]);
  }
  return {
    n,
    mean: n ? sum / n : NaN,
    error: n ? Math.sqrt(squares) / n : NaN,
    low: n ? low : NaN,
    high: n ? high : NaN,
  };
}

/** The row of figures over a chart. */
function figures(/** @type {Field} */ field, /** @type {string} */ unit, /** @type {string} */ size) {
  const { n, mean, error, low, high } = summary(field);
  const about = withError(mean, error);
  const figure = (/** @type {string} */ name, /** @type {string} */ text) =>
    make("div", {}, make("dt", { text: name }), make("dd", { text }));
  const left = field.done - n;
  return [
    make(
      "p",
      { class: "big", "data-mean": String(mean) },
      make("strong", { text: about.value }),
      make("span", { class: "plus-minus", text: ` ± ${about.error}` }),
      make("span", { class: "unit", text: ` ${unit}, mean` }),
    ),
    make(
      "dl",
      { class: "figures small" },
      figure("Least", `${digits(low)} ${unit}`),
      figure("Most", `${digits(high)} ${unit}`),
      figure("Uniformity", digits(low / mean, 2)),
      figure("Size", size),
    ),
    ...(left > 0 ? [make("p", { class: "soft", text: `${left} points lie inside a solid or behind a lamp and are left out.` })] : []),
  ];
}

const costLine = (/** @type {Field} */ f) =>
  make("p", {
    class: "soft",
    text: `${f.done} points, ${count(f.samples)} samples, ${count(f.rays)} rays, ${duration(f.seconds)}.`,
  });

/** A legend of colours with its ticks. */
export function legend(
  /** @type {import("./colours.js").Scale} */ scale,
  /** @type {string} */ unit,
  text = (/** @type {number} */ v) => String(v),
) {
  const strip = make("div", { class: "strip", "aria-hidden": "true" });
  strip.style.background = `linear-gradient(to right, ${Array.from({ length: 15 }, (_, i) => css(i / 14)).join(", ")})`;
  const ticks = make("div", { class: "ticks" });
  for (const tick of scale.ticks) {
    const at = scale.share(tick);
    if (at < -0.001 || at > 1.001) continue;
    const label = make("span", { text: text(tick) });
    label.style.left = `${100 * at}%`;
    ticks.append(label);
  }
  return make("div", { class: "scale" }, strip, ticks, make("span", { class: "unit", text: unit }));
}

/** The value between the centres of the cells, or that of the nearest one at the edge. */
function between(
  /** @type {Grid} */ { columns, rows },
  /** @type {Float64Array} */ lux,
  /** @type {number} */ x,
  /** @type {number} */ y,
) {
  const clamp = (/** @type {number} */ v, /** @type {number} */ n) => Math.min(n - 1, Math.max(0, v));
  const i = Math.min(columns - 2, Math.floor(clamp(x, columns))),
    j = Math.min(rows - 2, Math.floor(clamp(y, rows)));
  const fx = clamp(x, columns) - i,
    fy = clamp(y, rows) - j;
  const at = (/** @type {number} */ a, /** @type {number} */ b) => lux[b * columns + a];
  const mixed =
    (at(i, j) * (1 - fx) + at(i + 1, j) * fx) * (1 - fy) + (at(i, j + 1) * (1 - fx) + at(i + 1, j + 1) * fx) * fy;
  // Beside a point that is left out, the nearest one counts.
  return Number.isNaN(mixed) ? at(Math.round(clamp(x, columns)), Math.round(clamp(y, rows))) : mixed;
}

/** The colours of the grid over the picture, where the picture shows its plane. */
export function overlayOf(
  /** @type {Grid} */ grid,
  /** @type {Field | undefined} */ field,
  /** @type {import("./surfaces.js").SurfaceMap} */ map,
) {
  const canvas = make("canvas", { width: map.columns, height: map.rows });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const image = context.createImageData(map.columns, map.rows);
  const scale = field ? linearScale(summary(field).low, summary(field).high) : undefined;
  const near = 1e-3 * Math.max(grid.width, grid.height) + 1e-6;
  const { normal } = grid.plane;
  for (let j = 0; j < map.rows; ++j)
    for (let i = 0; i < map.columns; ++i) {
      const place = map.cell(i, j);
      if (!place || normal[0] * place.normal[0] + normal[1] * place.normal[1] + normal[2] * place.normal[2] < 0.98)
        continue;
      const { u, v, away } = inFrame(grid.plane, place.point);
      const x = ((u - grid.u0) / grid.width) * grid.columns - 0.5,
        y = ((v - grid.v0) / grid.height) * grid.rows - 0.5;
      if (Math.abs(away) > near || x < -0.5 || y < -0.5 || x > grid.columns - 0.5 || y > grid.rows - 0.5) continue;
      const value = field && scale ? between(grid, field.lux, x, y) : NaN;
      const [r, g, b] = scale && !Number.isNaN(value) ? colour(scale.share(value)) : [255, 255, 255];
      image.data.set([r, g, b, Number.isNaN(value) ? 70 : 215], 4 * (j * map.columns + i));
    }
  context.putImageData(image, 0, 0);
  return canvas;
}

/** Shows a grid: figures, the plan with lines of equal illuminance, the legend and a table. */
export function showGrid(
  /** @type {HTMLElement} */ box,
  /** @type {Grid} */ grid,
  /** @type {Field} */ field,
  /** @type {string} */ unit,
) {
  const { columns, rows } = grid;
  const { low, high, mean } = summary(field);
  const scale = linearScale(low, high);
  const cell = 16;
  const canvas = make("canvas", { width: columns * 4, height: rows * 4 });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  for (let y = 0; y < rows * 4; ++y)
    for (let x = 0; x < columns * 4; ++x) {
      const value = between(grid, field.lux, (x + 0.5) / 4 - 0.5, rows - 1 - ((y + 0.5) / 4 - 0.5));
      if (Number.isNaN(value)) continue;
      context.fillStyle = css(scale.share(value));
      context.fillRect(x, y, 1, 1);
    }
  const drawing = draw("svg", {
    viewBox: `0 0 ${columns * cell} ${rows * cell}`,
    role: "img",
    "aria-label": `Plan of the illuminance: least ${digits(low)}, most ${digits(high)}, on average ${digits(mean)} ${spoken(unit)}`,
  });
  /** @type {number[][]} */
  const labels = [];
  for (const level of scale.ticks.filter((t) => t > low && t < high))
    for (const points of joined(segments(field.lux, columns, rows, level))) {
      const at = points.map(([x, y]) => [(x + 0.5) * cell, (rows - 0.5 - y) * cell]);
      drawing.append(
        draw("polyline", { points: at.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" "), class: "isoline" }),
      );
      // A label where none is near; short lines have none.
      const spot = [0.5, 0.25, 0.75]
        .map((part) => at[Math.floor(part * at.length)])
        .find(([x, y]) => labels.every(([a, b]) => Math.abs(x - a) > 44 || Math.abs(y - b) > 22));
      if (at.length < 8 || !spot) continue;
      labels.push(spot);
      drawing.append(draw("text", { x: spot[0].toFixed(1), y: spot[1].toFixed(1), class: "isolabel" }, String(level)));
    }
  const plan = make("div", { class: "plan" }, canvas);
  plan.style.aspectRatio = `${columns} / ${rows}`;
  plan.append(drawing);
  const table = make("table", {}, make("caption", { text: `Illuminance [${unit}], rows from the top of the plan` }));
  for (let j = rows - 1; j >= 0; --j)
    table.append(
      make(
        "tr",
        {},
        ...Array.from({ length: columns }, (_, i) => make("td", { text: digits(field.lux[j * columns + i]) })),
      ),
    );
  box.replaceChildren(
    ...figures(field, unit, `${digits(grid.width)} × ${digits(grid.height)} m`),
    plan,
    legend(scale, unit),
    costLine(field),
    make(
      "details",
      {},
      make("summary", { text: `Table of ${columns} × ${rows} points` }),
      make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Table of the points" }, table),
    ),
  );
}

/** Shows a line: figures, and a chart with the interval of each point. */
export function showLine(
  /** @type {HTMLElement} */ box,
  /** @type {Line} */ line,
  /** @type {Field} */ field,
  /** @type {string} */ unit,
) {
  const width = 300,
    height = 150,
    left = 40,
    bottom = 24,
    top = 8;
  const { low, high, mean } = summary(field);
  const scale = linearScale(0, Math.max(...Array.from(field.upper, (v) => (Number.isNaN(v) ? 0 : v))));
  const x = (/** @type {number} */ i) => left + ((width - left - 6) * i) / (field.lux.length - 1);
  const y = (/** @type {number} */ v) => height - bottom - (height - bottom - top) * scale.share(v);
  const drawing = draw("svg", {
    viewBox: `0 0 ${width} ${height}`,
    class: "chart",
    role: "img",
    "aria-label":
      `Illuminance along the line: least ${digits(low)}, most ${digits(high)}, ` + `on average ${digits(mean)} ${spoken(unit)}`,
  });
  for (const tick of scale.ticks) {
    drawing.append(draw("line", { x1: left, x2: width - 6, y1: y(tick), y2: y(tick), class: "gridline" }));
    drawing.append(draw("text", { x: left - 5, y: y(tick) + 3, class: "axis end" }, String(tick)));
  }
  for (const part of [0, 0.5, 1])
    drawing.append(
      draw(
        "text",
        {
          x: x(part * (field.lux.length - 1)),
          y: height - 8,
          class: part === 1 ? "axis end" : part ? "axis middle" : "axis",
        },
        `${digits(part * line.length)}${part === 1 ? " m" : ""}`,
      ),
    );
  const known = Array.from(field.lux.keys()).filter((i) => !Number.isNaN(field.lux[i]));
  const path = (/** @type {Float64Array} */ values, order = known) =>
    order.map((i) => `${x(i).toFixed(1)},${y(values[i]).toFixed(1)}`).join(" ");
  drawing.append(
    draw("polygon", { points: `${path(field.upper)} ${path(field.lower, [...known].reverse())}`, class: "band" }),
  );
  drawing.append(draw("polyline", { points: path(field.lux), class: "curve" }));
  box.replaceChildren(
    ...figures(field, unit, `${digits(line.length)} m`),
    make(
      "figure",
      {},
      drawing,
      make("figcaption", { class: "soft", text: `Illuminance [${unit}] along the line, with 95 % intervals` }),
    ),
    costLine(field),
  );
}
