// The list of lights, with a switch and a slider for each.
import { byId, make } from "./dom.js";
import { digits } from "./format.js";

/** @typedef {import("./scene.js").OpenScene} OpenScene */
/** @typedef {import("./scene.js").Light} Light */

/** Rows of the list.  A page with thousands of sliders is of no use. */
const most = 100;

/** @type {Record<string, string>} */
const kinds = {
  point: "point",
  spot: "spot",
  distant: "distant",
  uniformInfinite: "uniform sky",
  diffuseArea: "area",
  projection: "projector",
  beam: "beam",
  goniometric: "luminaire",
  sun: "sun",
  imageInfinite: "picture sky",
};

export const kindOf = (/** @type {Light} */ light) => kinds[light.kind.case ?? ""] ?? "light";
export const nameOf = (/** @type {Light} */ light) => light.name || `${kindOf(light)} ${light.id}`;

/** The colour of a light as the screen shows it, at full brightness. */
export function cssOf(/** @type {[number, number, number] | undefined} */ rgb) {
  const most = Math.max(...(rgb ?? [0]));
  if (!rgb || !(most > 0)) return "rgb(128 128 128)";
  return `rgb(${rgb.map((v) => Math.round(255 * (Math.max(0, v) / most) ** (1 / 2.2))).join(" ")})`;
}

/**
 * Fills the list.
 * @param {OpenScene} scene
 * @param {() => void} changed is called at each change of a level
 */
export function showLights(scene, changed) {
  const reset = /** @type {HTMLButtonElement} */ (byId("lights-reset"));
  const rows = scene.lights.slice(0, most).map((light, i) =>
    row(scene, light, i, () => {
      reset.disabled = false;
      changed();
    }),
  );
  byId("lights").replaceChildren(...rows.map(({ item }) => item));
  const notes = [];
  if (scene.lights.length === 0) notes.push("This scene has no lights.");
  if (scene.lights.length > most) notes.push(`The first ${most} of ${scene.lights.length} lights.`);
  if (!scene.mayEdit) notes.push("Your token may not change lights: that needs the role load.");
  byId("lights-note").textContent = notes.join(" ");
  reset.disabled = !scene.lights.some(({ id }) => scene.level(id).scale !== 1 || !scene.level(id).on);
  reset.onclick = () => {
    scene.resetLevels();
    for (const { update } of rows) update();
    reset.disabled = true;
    changed();
  };
}

/** One light.  `update` shows its level of now. */
function row(
  /** @type {OpenScene} */ scene,
  /** @type {Light} */ light,
  /** @type {number} */ i,
  /** @type {() => void} */ changed,
) {
  const name = nameOf(light),
    power = scene.powers[i];
  const toggle = make("input", {
    type: "checkbox",
    role: "switch",
    "aria-label": `${name} is on`,
    disabled: !scene.mayEdit,
  });
  const slider = make("input", {
    type: "range",
    min: 0,
    max: 200,
    step: 1,
    "aria-label": `Level of ${name}`,
    disabled: !scene.mayEdit,
  });
  const value = make("output", {});
  const swatch = make("span", { class: "swatch", "aria-hidden": "true" });
  swatch.style.background = cssOf(power?.rgb);
  const item = make(
    "li",
    { class: "light", "data-light": String(light.id) },
    make(
      "div",
      { class: "light-head" },
      swatch,
      make("span", { class: "light-name", text: name, title: light.source }),
      make("span", {
        class: "soft",
        text: `${light.name ? `${kindOf(light)}, ` : ""}${digits(power?.lumens ?? light.powerLm)} ${power?.unit ?? "lm"}`,
      }),
      toggle,
    ),
    make("div", { class: "light-level" }, slider, value),
  );
  const update = () => {
    const { scale, on } = scene.level(light.id);
    toggle.checked = on;
    slider.value = String(Math.round(scale * 100));
    slider.style.setProperty("--part", `${Number(slider.value) / 2}%`);
    slider.setAttribute("aria-valuetext", `${slider.value} percent`);
    value.textContent = `${slider.value} %`;
    item.classList.toggle("off", !on || scale === 0);
  };
  const set = () => {
    scene.setLevel(light.id, { scale: Number(slider.value) / 100, on: toggle.checked });
    update();
    changed();
  };
  toggle.addEventListener("change", set);
  slider.addEventListener("input", set);
  update();
  return { item, update };
}
