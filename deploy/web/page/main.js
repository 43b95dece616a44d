// The page: joins the scene, the picture, the measurements and the dials.
import { textOf } from "./api.js";
import { Dial } from "./dial.js";
import { afterCalm, byId, say } from "./dom.js";
import { legend, measureField, overlayOf, showGrid, showLine } from "./field.js";
import { count, digits, duration, metres, percent } from "./format.js";
import { grid as gridOf, isInPlane, line as lineOf } from "./geometry.js";
import { cssOf, nameOf, showLights } from "./lights.js";
import { Latest } from "./latest.js";
import { Picture, render } from "./picture.js";
import { commandOf, measurePoint, showPoint } from "./point.js";
import { illuminanceUnitOf, OpenScene } from "./scene.js";
import { showScenes } from "./scene_list.js";
import { handled, startSession } from "./session.js";
import { surfaceAt, SurfaceMap } from "./surfaces.js";
import { drawMarks, listen, paint } from "./view.js";

/** @typedef {import("./view.js").Pixel} Pixel */
/** @typedef {import("./geometry.js").Place} Place */
/** @typedef {"point" | "line" | "grid"} Tool */

const frame = byId("picture");
const pointBox = byId("result-point"),
  mapBox = byId("result-map"),
  emptyNote = byId("result-empty");
const exposure = /** @type {HTMLInputElement} */ (byId("exposure"));

/** @type {OpenScene | undefined} */
let scene;
/** @type {Picture | undefined} */
let picture;
/** @type {SurfaceMap | undefined} */
let map;
/** @type {Tool} */
let tool = "point";
/** @type {"photo" | "luminance" | "error"} */
let view = "photo";
/** @type {Pixel | undefined} */
let cursor;
/** What is measured, so that it can be measured again when lights or the accuracy change. */
/** @type {{tool: Tool, pixels: Pixel[], places: Place[]} | undefined} */
let subject;
/** The first end of a line or a grid. */
/** @type {{pixel: Pixel, place: Place} | undefined} */
let first;
/** @type {HTMLCanvasElement | undefined} */
let overlay;

const opening = new Latest(reopen),
  rendering = new Latest(reopen),
  mapping = new Latest(reopen),
  measuring = new Latest(reopen),
  editing = new Latest(reopen);

const errorDial = new Dial(byId("dial-error"), {
  name: "Measurements, relative error",
  steps: [0.2, 0.1, 0.05, 0.02, 0.01, 0.005],
  start: 0.02,
  text: (step) => `${Number((step * 100).toPrecision(3))} %`,
  prefix: "± ",
  changed: () => measureAgain(),
});
const samplesDial = new Dial(byId("dial-samples"), {
  name: "Picture, samples of a pixel",
  steps: [4, 16, 64, 256, 1024],
  start: 16,
  text: (step) => String(step),
  prefix: "",
  changed: () => startPicture(),
});

// The picture.

/** @type {import("./colours.js").Scale | undefined} */
let viewScale;
let paintAsked = false;

function repaint() {
  if (paintAsked) return;
  paintAsked = true;
  requestAnimationFrame(() => {
    paintAsked = false;
    if (picture?.started) viewScale = paint(picture, view, Number(exposure.value));
    const box = byId("view-legend");
    box.hidden = !viewScale;
    if (viewScale)
      box.replaceChildren(view === "error" ? legend(viewScale, "± error", percent) : legend(viewScale, "cd/m²"));
    redrawMarks();
  });
}

function redrawMarks() {
  if (!picture) return;
  const pins = first ? [first.pixel] : (subject?.pixels ?? []);
  const line =
    first && cursor && tool === "line"
      ? { from: first.pixel, to: cursor }
      : subject?.tool === "line" && !first
        ? { from: subject.pixels[0], to: subject.pixels[1] }
        : undefined;
  drawMarks({ cursor, pins, line, overlay }, picture.width, picture.height);
}

function startPicture() {
  if (!scene) return;
  const { id, summary } = scene;
  const samples = samplesDial.value;
  const next = new Picture(summary.imageWidth, summary.imageHeight, summary.filmScale || 1);
  const progress = /** @type {HTMLProgressElement} */ (byId("progress"));
  rendering.run(async (signal) => {
    frame.setAttribute("aria-busy", "true");
    progress.value = 0;
    let lastStatus = 0;
    await render(id, samples, next, signal, ({ samplesDone, samplesTotal, cost, tile }) => {
      // The picture before stays until the first one of this scene is whole.
      const share = Number(samplesDone) / Number(samplesTotal);
      if (!picture?.started || Number(samplesDone) >= next.width * next.height) picture = next;
      progress.value = share;
      repaint();
      if (picture !== next || (performance.now() - lastStatus < 200 && share < 1)) return;
      lastStatus = performance.now();
      const done = Number(samplesDone) / (next.width * next.height);
      byId("picture-samples").textContent = `${share < 1 ? `${digits(done, 2)} of ` : ""}${samples}`;
      const error = next.medianError();
      byId("picture-error").textContent = Number.isNaN(error) ? "–" : `± ${percent(error)}, median`;
      const rays = Number((cost?.cameraRays ?? 0n) + (cost?.indirectRays ?? 0n) + (cost?.shadowRays ?? 0n));
      byId("picture-cost").textContent = `${count(rays)} rays, ${duration(cost?.wallTimeS ?? 0)}`;
      if (share >= 1) samplesDial.measured(samples, cost?.wallTimeS ?? 0);
    });
    frame.setAttribute("aria-busy", "false");
    frame.dataset.scene = id;
    frame.dataset.samples = String(samples);
  }, byId("result-error"));
}

// Measurements.

const spokenPlace = afterCalm(400, () => {
  if (cursor && picture) say(`${byId("hover").textContent}, column ${cursor.x}, row ${cursor.y}`);
});

function moved(/** @type {Pixel | undefined} */ at, /** @type {boolean} */ byKey) {
  cursor = at;
  const box = byId("hover");
  if (!at || !picture?.started) {
    box.textContent = "–";
  } else {
    const luminance = picture.luminance[at.y * picture.width + at.x];
    const place = map?.at(at.x, at.y);
    box.textContent = `${digits(luminance)} cd/m²`;
    box.dataset.luminance = String(luminance);
    box.title = place ? `at ${place.point.map(metres).join(", ")} m` : "no surface";
    if (byKey) spokenPlace();
    if (first && tool === "grid" && place && map)
      overlay = overlayOf(gridOf(first.place, place.point, 4), undefined, map);
  }
  redrawMarks();
}

function clear() {
  measuring.end();
  subject = first = overlay = undefined;
  pointBox.hidden = mapBox.hidden = true;
  emptyNote.hidden = false;
  byId("result-error").textContent = "";
  showHint();
  redrawMarks();
}

function showHint() {
  const hints = {
    point: "Click on a surface",
    line: first ? "Click where the line ends" : "Click where the line begins",
    grid: first ? "Click on the opposite corner" : "Click on a corner of the grid",
  };
  // After a measurement, the hint would only hide the picture.
  byId("hint").textContent = subject?.tool === tool && !first ? "" : hints[tool];
}

function pick(/** @type {Pixel} */ pixel) {
  if (!scene) return;
  const { id } = scene;
  measuring.run(async (signal) => {
    const place = await surfaceAt(id, pixel.x, pixel.y, signal);
    if (!place) throw new Error("The camera sees no surface there.");
    if (tool !== "point" && !first) {
      first = { pixel, place };
      subject = overlay = undefined;
      say("First point set. Move the cross-hair, and press Enter again.");
    } else {
      subject = first
        ? { tool, pixels: [first.pixel, pixel], places: [first.place, place] }
        : { tool, pixels: [pixel], places: [place] };
      first = undefined;
      showHint();
      await measure(signal);
      if (subject.places[1] && !isInPlane(subject.places[0], place.point))
        byId("result-error").textContent =
          "The ends lie on different surfaces. The points lie in the plane of the first end.";
    }
    showHint();
    redrawMarks();
  }, byId("result-error"));
}

function measureAgain() {
  if (subject) measuring.run(measure, byId("result-error"));
}

/** Says that a field is measured, and keeps the time that it took. */
function toldField(/** @type {string} */ what, /** @type {number} */ error, /** @type {number} */ seconds) {
  errorDial.measured(error, seconds);
  say(`${what} measured. ${mapBox.querySelector("svg")?.getAttribute("aria-label")}`);
}

/** Measures the subject. */
async function measure(/** @type {AbortSignal} */ signal) {
  if (!scene || !subject) return;
  const { id, illuminanceUnit } = scene,
    error = errorDial.value,
    { places } = subject;
  emptyNote.hidden = true;
  pointBox.hidden = subject.tool !== "point";
  mapBox.hidden = subject.tool === "point";
  const box = subject.tool === "point" ? pointBox : mapBox;
  box.setAttribute("aria-busy", "true");
  if (subject.tool === "point") {
    overlay = undefined;
    await measureOne(id, places[0], error, signal);
  } else if (subject.tool === "line") {
    overlay = undefined;
    const line = lineOf(places[0], places[1].point, 61);
    const field = await measureField(id, line.points, line.plane.normal, error, signal, (f) =>
      showLine(mapBox, line, f, illuminanceUnit),
    );
    toldField("Line", error, field.seconds);
  } else {
    const grid = gridOf(places[0], places[1].point, 32);
    const field = await measureField(id, grid.points, grid.plane.normal, error, signal, (f) => {
      showGrid(mapBox, grid, f, illuminanceUnit);
      if (map) overlay = overlayOf(grid, f, map);
      redrawMarks();
    });
    toldField("Grid", error, field.seconds);
  }
  box.setAttribute("aria-busy", "false");
  box.dataset.scene = id;
  box.dataset.error = String(error);
  box.dataset.places = JSON.stringify(places);
  redrawMarks();
}

async function measureOne(
  /** @type {string} */ id,
  /** @type {Place} */ place,
  /** @type {number} */ error,
  /** @type {AbortSignal} */ signal,
) {
  const answer = await measurePoint(id, place, error, signal);
  if (!scene || !subject) return;
  const { lights, powers, isEdited, path } = scene;
  const pixel = subject.pixels[0];
  const spoken = showPoint(pointBox, {
    answer,
    place,
    luminance: picture?.luminance[pixel.y * picture.width + pixel.x] ?? NaN,
    command: commandOf(isEdited ? id : path, place, error),
    unit: scene.illuminanceUnit,
    lightOf: (lightId) => {
      const i = lights.findIndex((light) => light.id === lightId);
      return i < 0
        ? { name: `light ${lightId}`, css: cssOf(undefined), unit: "lx" }
        : { name: nameOf(lights[i]), css: cssOf(powers[i]?.rgb), unit: illuminanceUnitOf(powers[i]?.unit ?? "lm") };
    },
  });
  errorDial.measured(error, answer.cost?.wallTimeS ?? 0);
  say(spoken);
}

// Lights and scenes.

const applyLevels = afterCalm(120, () => {
  const edited = scene;
  editing.run(async () => {
    if (!(await edited?.applyLevels()) || edited !== scene) return;
    startPicture();
    measureAgain();
  }, byId("lights-note"));
});

/** Shows everything of a scene that is open. */
function showScene(/** @type {OpenScene} */ opened) {
  const { summary, path } = opened;
  document.title = `${path} – Lucerna`;
  const remarks = opened.remarks ? `, ${count(opened.remarks)} things not modelled` : "";
  byId("scene-title").textContent = path;
  byId("scene-title").title =
    `${count(Number(summary.primitives))} primitives, ${opened.lights.length} lights${remarks}`;
  byId("stage-title").textContent = `Picture of ${path}`;
  frame.style.setProperty("--ratio", String(summary.imageWidth / summary.imageHeight));
  showLights(opened, applyLevels);
  for (const button of byId("scenes").querySelectorAll("button"))
    button.setAttribute("aria-current", String(button.dataset.path === path));
  mapping.run(async (signal) => {
    map = await SurfaceMap.read(opened.id, summary.imageWidth, summary.imageHeight, signal);
    frame.dataset.map = path;
  }, byId("result-error"));
  startPicture();
}

function openScene(/** @type {string} */ path, /** @type {string | undefined} */ id) {
  const note = byId("scenes-note");
  opening.run(async (signal) => {
    note.textContent = `Loading ${path} …`;
    const opened = await OpenScene.open(path, id);
    if (signal.aborted) return opened.close();
    note.textContent = "";
    scene?.close();
    rendering.end();
    scene = opened;
    picture = map = undefined;
    errorDial.forget();
    samplesDial.forget();
    samplesDial.value = opened.summary.samplesPerPixel ?? 16;
    exposure.value = "0";
    exposure.dispatchEvent(new Event("input"));
    clear();
    showScene(opened);
  }, note);
}

/** Opens the same scene again, with the levels of its lights.  False if that fails, too. */
async function reopen() {
  const before = scene;
  if (!before) return false;
  try {
    const opened = await OpenScene.open(before.path, undefined);
    if (scene !== before) return true;
    opened.takeLevels(before);
    before.close();
    scene = opened;
    await opened.applyLevels();
    showScene(opened);
    measureAgain();
    return true;
  } catch (error) {
    return handled(error);
  }
}

startSession(async () => {
  try {
    const scenes = await showScenes(scene?.path, openScene);
    if (scene) await reopen();
    else if (scenes.length) openScene(scenes[0].path, scenes[0].id);
  } catch (error) {
    if (!handled(error)) byId("scenes-note").textContent = textOf(error);
  }
});

listen(() => ({ x: picture?.width ?? 1, y: picture?.height ?? 1 }), { move: moved, pick, clear });
for (const input of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll("input[name=tool]")))
  input.addEventListener("change", () => {
    tool = /** @type {Tool} */ (input.value);
    first = undefined;
    if (!subject) overlay = undefined;
    showHint();
    redrawMarks();
  });
for (const input of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll("input[name=view]")))
  input.addEventListener("change", () => {
    view = /** @type {typeof view} */ (input.value);
    exposure.disabled = view !== "photo";
    viewScale = undefined;
    repaint();
  });
exposure.addEventListener("input", () => {
  const text = `${Number(exposure.value) > 0 ? "+" : ""}${exposure.value.replace("-", "−")} EV`;
  byId("exposure-value").textContent = text;
  exposure.ariaValueText = text;
  exposure.style.setProperty("--part", `${((Number(exposure.value) + 6) / 12) * 100}%`);
  repaint();
});
exposure.dispatchEvent(new Event("input"));
new ResizeObserver(redrawMarks).observe(frame);
showHint();
