// The illuminance at one point of a surface, and each light's share.
import { lighting } from "./api.js";
import { make } from "./dom.js";
import { count, digits, duration, metres, percent, spoken, withError } from "./format.js";

/** @typedef {import("./geometry.js").Place} Place */
/** @typedef {import("../../generated/lucerna/v1/lighting_pb.js").EstimateIrradianceResponse} Answer */

/** Errors need not be smaller than this [lx]. */
export const floorLx = 0.01;
const insideSolid = 8;

/** Asks for the illuminance at a point. */
export function measurePoint(
  /** @type {string} */ sceneId,
  /** @type {Place} */ place,
  /** @type {number} */ relative,
  /** @type {AbortSignal} */ signal,
) {
  const [x, y, z] = place.point;
  return lighting.estimateIrradiance(
    {
      sceneId,
      // As the client does for a single point, so that its answer has the same bits.
      receivers: { originM: { x, y, z }, offsetsM: [0, 0, 0] },
      normals: place.normal,
      perLight: true,
      accuracy: { stop: { case: "targetError", value: { relative, absoluteFloor: floorLx } } },
    },
    { signal },
  );
}

/** A word of a shell. */
const word = (/** @type {string} */ text) =>
  /^[\w./,:=%@+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;

/** The shortest text that gives the same float. */
function float(/** @type {number} */ value) {
  for (let precision = 1; precision < 9; ++precision) {
    const text = String(Number(value.toPrecision(precision)));
    if (Math.fround(Number(text)) === value) return text;
  }
  return String(value);
}

/** The command of `lucerna` that gives the same answer. */
export function commandOf(
  /** @type {string} */ scene,
  /** @type {Place} */ { point, normal },
  /** @type {number} */ relative,
) {
  return [
    "lucerna irradiance",
    word(scene),
    `--point=${point.join(",")}`,
    `--normal=${normal.map(float).join(",")}`,
    `--error=${Number((relative * 100).toPrecision(6))}%`,
    `--floor=${floorLx}`,
    "--per-light",
  ].join(" ");
}

/**
 * The bars: the direct light of each light, and all reflected light, the largest first.
 * @param {Answer} answer
 * @param {(id: bigint) => {name: string, css: string, unit: string}} lightOf
 * @param {string} unit
 */
function shares(answer, lightOf, unit) {
  const total = answer.illuminanceLx[0];
  const rows = answer.shares.map(({ lightId, illuminanceLx }) => ({
    ...lightOf(lightId),
    lux: illuminanceLx[0],
    isReflected: false,
  }));
  const direct = rows.reduce((sum, row) => sum + row.lux, 0);
  const lux = Math.max(0, total - direct);
  rows.push({ name: "Reflected light", css: "var(--reflected)", unit, lux, isReflected: true });
  return rows.sort((a, b) => b.lux - a.lux);
}

/**
 * Shows the answer.
 * @param {HTMLElement} box
 * @param {{answer: Answer, place: Place, luminance: number, command: string, unit: string,
 *   lightOf: (id: bigint) => {name: string, css: string, unit: string}}} shown
 */
export function showPoint(box, { answer, place, luminance, command, unit, lightOf }) {
  const lux = answer.illuminanceLx[0],
    lower = answer.lowerLx[0],
    upper = answer.upperLx[0];
  const { value, error } = withError(lux, (upper - lower) / 2);
  const isInside = answer.status[0] === insideSolid;
  const most = 12;
  const rows = shares(answer, lightOf, unit),
    largest = Math.max(rows[0]?.lux ?? 0, 1e-30);
  const bars = rows.slice(0, most).map((row) => {
    const share = lux > 0 ? row.lux / lux : 0;
    const fill = make("span", { class: "fill" });
    fill.style.width = `${(100 * row.lux) / largest}%`;
    const swatch = make("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = row.css;
    return make(
      "li",
      { class: row.isReflected ? "reflected" : "" },
      make("span", { class: "bar-name" }, swatch, row.name),
      make(
        "span",
        { class: "bar-value" },
        `${digits(row.lux)} ${row.unit}`,
        make("span", { class: "soft", text: ` ${percent(share)}` }),
      ),
      make("span", { class: "track", "aria-hidden": "true" }, fill),
    );
  });
  const copy = make("button", {
    type: "button",
    class: "quiet",
    text: "Copy",
    "aria-label": "Copy the command",
    onclick: async () => {
      await navigator.clipboard.writeText(command);
      copy.textContent = "Copied";
    },
  });
  box.replaceChildren(
    make(
      "p",
      {
        class: "big",
        "data-lux": String(lux),
        "data-point": place.point.join(","),
        "data-normal": place.normal.join(","),
      },
      make("strong", { text: value }),
      make("span", { class: "plus-minus", text: ` ± ${error}` }),
      make("span", { class: "unit", text: ` ${unit}` }),
    ),
    make("p", {
      class: "soft",
      text: isInside
        ? "This point lies inside a solid or behind a lamp: no light reaches it."
        : `95 % interval: ${digits(lower, 4)} to ${digits(upper, 4)} ${unit}`,
    }),
    make("h3", { text: "Where the light comes from" }),
    make("ul", { class: "bars" }, ...bars),
    ...(rows.length > most ? [make("p", { class: "soft", text: `${rows.length - most} more lights give less.` })] : []),
    make(
      "dl",
      { class: "pairs" },
      make("dt", { text: "Position" }),
      make("dd", { text: `${place.point.map(metres).join("  ")} m` }),
      make("dt", { text: "Normal" }),
      make("dd", { text: place.normal.map(metres).join("  ") }),
      make("dt", { text: "Luminance" }),
      make("dd", { text: `${digits(luminance)} cd/m²` }),
      make("dt", { text: "Samples" }),
      make("dd", { text: answer.samples ? count(answer.samples) : "none, exact" }),
      make("dt", { text: "Cost" }),
      make("dd", { text: costOf(answer) }),
    ),
    make(
      "details",
      { class: "command" },
      make("summary", { text: "The same from the command line" }),
      make("code", { text: command }),
      copy,
    ),
  );
  return `${value} plus or minus ${error} ${spoken(unit)}. ${rows
    .slice(0, 3)
    .map((row) => `${row.name} ${digits(row.lux)}`)
    .join(", ")}.`;
}

/** Rays and time of an answer. */
function costOf(/** @type {Answer} */ { cost }) {
  const rays = Number((cost?.shadowRays ?? 0n) + (cost?.indirectRays ?? 0n));
  return `${count(rays)} rays, ${duration(cost?.wallTimeS ?? 0)}`;
}
