// The page in Debian's Chromium: what a user sees and does.  Numbers are compared with those of `lucerna`.
import assert from "node:assert/strict";
import { readFileSync, rmSync, writeFileSync } from "node:fs";
import test, { after, afterEach, before, beforeEach } from "node:test";

import { grid as gridOf } from "../../deploy/web/page/geometry.js";
import { lucerna, require, startBrowser, startGateway, startServer, stopAll } from "./programs.mjs";
import { makeScenes } from "./scene.mjs";

const limit = { timeout: 600_000 };
const scenes = makeScenes();
let server;
let gateway;
let chromium;
let page;
/** What the console of the page said. */
let complaints;

before(async () => {
  server = await startServer({ scenes, options: ["--load=lamps.pbrt"] });
  gateway = await startGateway(server.address);
  chromium = await startBrowser();
}, limit);

after(async () => {
  await chromium?.close();
  await stopAll();
  rmSync(scenes, { recursive: true });
}, limit);

beforeEach(async () => {
  page = await open();
}, limit);

afterEach(async () => {
  await page.close();
  assert.deepEqual(complaints, []);
}, limit);

/** Opens the page, and waits for its picture. */
async function open({ width = 1280, height = 900, theme = "dark", address = gateway.address } = {}) {
  const opened = await chromium.browser.newPage();
  complaints = [];
  opened.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
  opened.on("pageerror", (error) => complaints.push(error.message));
  opened.setDefaultTimeout(120_000);
  await opened.setViewport({ width, height });
  await opened.emulateMediaFeatures([{ name: "prefers-color-scheme", value: theme }]);
  await opened.goto(address);
  await opened.waitForSelector("#picture[data-scene][data-map]");
  return opened;
}

const text = (selector) => page.$eval(selector, (e) => e.textContent.trim());
/** The scene that the picture shows now. */
const shownScene = () => page.$eval("#picture", (e) => e.dataset.scene);

/** Clicks on the middle of a pixel of the picture, of 60 x 40. */
async function click(x, y) {
  const box = await page.$eval("#canvas", (canvas) => {
    canvas.scrollIntoView({ block: "center" });
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return { left, top, width, height };
  });
  await page.mouse.click(box.left + ((x + 0.5) / 60) * box.width, box.top + ((y + 0.5) / 40) * box.height);
}

/** Waits until the measurement of the scene of now is there, and returns its numbers. */
async function measured(selector = "#result-point") {
  await page.waitForFunction(
    (box, picture) => {
      const { dataset, ariaBusy, hidden } = document.querySelector(box);
      return !hidden && dataset.error && dataset.scene && ariaBusy === "false" && dataset.scene === document.querySelector(picture).dataset.scene;
    },
    {},
    selector,
    "#picture",
  );
  return page.$eval(selector, (box) => {
    const big = box.querySelector(".big");
    return { ...big.dataset, shown: big.textContent, command: box.querySelector("code")?.textContent, places: JSON.parse(box.dataset.places) };
  });
}

/** The illuminance that `lucerna` gives for the command that the page shows. */
async function answerOf(command) {
  const words = command.split(" ");
  assert.deepEqual(words.slice(0, 2), ["lucerna", "irradiance"]);
  return JSON.parse(await lucerna(server.address, "--json", ...words.slice(1)));
}

/** Sets a slider as a user's hand does. */
const slide = (selector, value) =>
  page.$eval(
    selector,
    (slider, to) => {
      slider.value = to;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      slider.dispatchEvent(new Event("change", { bubbles: true }));
    },
    String(value),
  );

test("the scene, its lights and its picture appear", limit, async () => {
  assert.match(await page.title(), /^lamps\.pbrt/);
  assert.match(await text("#server"), /^lucernad \d+\.\d+\.\d+, \d+ threads$/);
  const names = await page.$$eval("#scenes button", (buttons) => buttons.map((b) => [b.textContent, b.ariaCurrent]));
  assert.deepEqual(names, [["lamps.pbrt", "true"], ["broken.pbrt", "false"]]);
  const lights = await page.$$eval(".light", (rows) => rows.map((row) => row.querySelector(".light-name").textContent));
  assert.deepEqual(lights, ["left", "right"]);
  // 4 pi 100 cd.
  assert.match(await text(".light-head .soft"), /1260 lm/);
  const colours = await page.$eval("#canvas", (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return [canvas.width, canvas.height, new Set(new Uint32Array(data.buffer)).size];
  });
  assert.deepEqual(colours.slice(0, 2), [60, 40]);
  assert.ok(colours[2] > 100, `${colours[2]} colours`);
  assert.equal(await text("#picture-samples"), "4");
  assert.match(await text("#picture-error"), /^± \d.*%, median$/);
  assert.match(await text("#picture-cost"), /rays, \d/);
});

test("a click gives the number that lucerna gives for that point", limit, async () => {
  await click(30, 25);
  const { lux, point, shown, command } = await measured();
  const answer = await answerOf(command);
  assert.equal(Number(lux), Math.fround(answer.illuminanceLx[0]));
  assert.ok(command.includes(`--point=${point}`), command);
  assert.ok(Math.abs(Number(point.split(",")[2])) < 1e-6, point); // on the floor
  const [value, error] = shown.match(/[\d.]+/g).map(Number);
  assert.ok(Math.abs(value - answer.illuminanceLx[0]) <= error, shown);
  assert.ok(Math.abs(error - (answer.upperLx[0] - answer.lowerLx[0]) / 2) <= 0.06 * error, `${shown}: ${answer.lowerLx[0]} to ${answer.upperLx[0]}`);
  // The bars: each light's direct light, and the rest.
  const bars = Object.fromEntries(
    await page.$$eval(".bars li", (rows) => rows.map((row) => [row.querySelector(".bar-name").textContent, parseFloat(row.querySelector(".bar-value").textContent)])),
  );
  const direct = answer.shares.map(({ illuminanceLx }) => illuminanceLx[0]);
  const rounding = 0.005;
  for (const [name, lux] of [["left", direct[0]], ["right", direct[1]], ["Reflected light", answer.illuminanceLx[0] - direct[0] - direct[1]]])
    assert.ok(Math.abs(bars[name] - lux) <= rounding * lux + 1e-3, `${name}: ${bars[name]}, not ${lux}`);
});

test("the number of the direct light is that of the formula", limit, async () => {
  await click(30, 25);
  const { point } = await measured();
  const [x, y, z] = point.split(",").map(Number);
  const bars = await page.$$eval(".bars li", (rows) => rows.map((row) => [row.querySelector(".bar-name").textContent, parseFloat(row.querySelector(".bar-value").textContent)]));
  // I cos / d^2 of the lamp of 100 cd at (-1, 0, 2).
  const expected = (100 * (2 - z)) / Math.hypot(x + 1, y, 2 - z) ** 3;
  const left = bars.find(([name]) => name === "left")[1];
  assert.ok(Math.abs(left - expected) < 0.005 * expected, `${left}, not ${expected}`);
});

test("hovering shows the luminance of the pixel in the picture of lucerna", limit, async () => {
  const file = `${scenes}/picture.pfm`;
  await lucerna(server.address, "render", "lamps.pbrt", "--samples=4", "--stderr", `${scenes}/error.pfm`, "-o", file);
  const bytes = readFileSync(file);
  const start = bytes.length - 60 * 40 * 3 * 4; // little-endian floats, rows from the bottom
  const box = await page.$eval("#canvas", (canvas) => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return { left, top, width, height };
  });
  for (const [x, y] of [[5, 35], [30, 25], [42, 20], [59, 39]]) {
    await page.mouse.move(box.left + ((x + 0.5) / 60) * box.width, box.top + ((y + 0.5) / 40) * box.height);
    const shown = await page.$eval("#hover", (e) => [e.textContent, Number(e.dataset.luminance)]);
    const at = start + 12 * ((39 - y) * 60 + x);
    const luminance = 0.2126 * bytes.readFloatLE(at) + 0.7152 * bytes.readFloatLE(at + 4) + 0.0722 * bytes.readFloatLE(at + 8);
    assert.ok(Math.abs(shown[1] - luminance) <= 1e-5 * luminance, `pixel ${x}, ${y}: ${shown[1]}, not ${luminance}`);
    assert.match(shown[0], /^[\d.]+ cd\/m²$/);
  }
});

test("half the level of the only light halves the number", limit, async () => {
  await page.click('[data-light="2"] input[role=switch]');
  await page.waitForFunction((before) => document.querySelector("#picture").dataset.scene !== before, {}, await shownScene());
  await click(24, 25);
  const full = await measured();
  const before = await shownScene();
  await slide('[data-light="1"] input[type=range]', 50);
  await page.waitForFunction((id) => document.querySelector("#picture").dataset.scene !== id, {}, before);
  const half = await measured();
  // The samples of both are of the same light, up to its level, so only the error that was asked for parts them.
  const ratio = Number(half.lux) / Number(full.lux);
  assert.ok(Math.abs(ratio - 0.5) < 0.02, `${full.lux} became ${half.lux}`);
  assert.match(half.command, new RegExp(`irradiance ${await shownScene()} `));
  assert.equal(Number(half.lux), Math.fround((await answerOf(half.command)).illuminanceLx[0]));
  // The revision before is gone from the server, and the scene of the file is there.
  const loaded = JSON.parse(await lucerna(server.address, "--json", "scenes")).scenes.map(({ sceneId }) => sceneId);
  assert.ok(!loaded.includes(before));
  assert.ok(loaded.includes(await shownScene()));
  await page.click("#lights-reset");
  await page.waitForFunction((id) => document.querySelector("#picture").dataset.scene !== id, {}, await shownScene());
  assert.match((await measured()).command, /irradiance lamps\.pbrt /);
});

test("a grid gives a map whose numbers are those of lucerna", limit, async () => {
  await page.click("input[value=grid]");
  await click(12, 33);
  await page.waitForFunction(() => document.querySelector("#hint").textContent.includes("opposite"));
  await click(46, 22);
  const { places, mean } = await measured("#result-map");
  const { points, columns, rows } = gridOf(places[0], places[1].point, 32);
  const cells = await page.$$eval("#result-map td", (all) => all.map((cell) => Number(cell.textContent)));
  assert.equal(cells.length, columns * rows);
  const some = [0, 17, Math.floor(points.length / 2), points.length - 1];
  writeFileSync(`${scenes}/points.csv`, some.map((i) => points[i].join(",")).join("\n"));
  const answer = JSON.parse(await lucerna(server.address, "--json", "irradiance", "lamps.pbrt", `--points=${scenes}/points.csv`, "--normal=0,0,1", "--error=0.5%"));
  some.forEach((i, k) => {
    // Rows of the table are from the top of the plan.
    const shown = cells[(rows - 1 - Math.floor(i / columns)) * columns + (i % columns)], lux = answer.illuminanceLx[k];
    assert.ok(Math.abs(shown - lux) < 0.05 * lux + 0.02 * Number(mean), `cell ${i}: ${shown}, not ${lux}`);
  });
  assert.ok((await page.$$("#result-map .isoline")).length > 2);
  const ticks = await page.$$eval("#result-map .ticks span", (all) => all.map((e) => Number(e.textContent)));
  assert.ok(ticks.length >= 3 && ticks.every((tick, i) => i === 0 || tick > ticks[i - 1]), String(ticks));
  // The colours of the map lie over the picture.
  const painted = await page.$eval("#marks", (marks) => {
    const { data } = marks.getContext("2d").getImageData(0, 0, marks.width, marks.height);
    let n = 0;
    for (let i = 3; i < data.length; i += 4) n += data[i] > 150;
    return n / (data.length / 4);
  });
  assert.ok(painted > 0.1 && painted < 0.9, `${painted} of the picture`);
});

test("a line gives a chart from one end to the other", limit, async () => {
  await page.click("input[value=line]");
  await click(12, 28);
  await page.waitForFunction(() => document.querySelector("#hint").textContent.includes("ends"));
  await click(46, 28);
  const { places } = await measured("#result-map");
  const distance = Math.hypot(...places[0].point.map((v, i) => v - places[1].point[i]));
  const size = parseFloat((await page.$$eval("#result-map .figures dd", (all) => all.map((e) => e.textContent)))[3]);
  assert.ok(Math.abs(size - distance) < 0.01 * distance, `${size} m, not ${distance}`);
  assert.equal(await page.$eval("#result-map .curve", (e) => e.getAttribute("points").split(" ").length), 61);
});

test("the dial changes the error, and keeps the time of each step", limit, async () => {
  await click(30, 25);
  const coarse = await measured();
  await slide("#dial-error-slider", 4);
  await page.waitForFunction(() => document.querySelector("#result-point").dataset.error === "0.01");
  const fine = await measured();
  const half = (shown) => Number(shown.match(/[\d.]+/g)[1]) / Number(shown.match(/[\d.]+/g)[0]);
  assert.ok(half(coarse.shown) <= 0.025, coarse.shown);
  assert.ok(half(fine.shown) <= 0.0125 && half(fine.shown) < half(coarse.shown), fine.shown);
  const times = await page.$$eval("#dial-error .time-value", (all) => all.map((e) => e.textContent));
  assert.deepEqual(times.map((time) => time !== "–"), [false, false, false, true, true, false]);
});

test("the picture starts again with more samples, and its error falls", limit, async () => {
  const error = async () => parseFloat((await text("#picture-error")).slice(2));
  // Four samples miss the rare light of reflections, and its error: the comparison begins at 16.
  await slide("#dial-samples-slider", 1);
  await page.waitForSelector('#picture[data-samples="16"]');
  const before = await error();
  await slide("#dial-samples-slider", 3);
  await page.waitForSelector('#picture[data-samples="256"]');
  assert.ok((await error()) < before / 2, `${before} became ${await error()}`);
  assert.equal(await text("#picture-samples"), "256");
});

test("luminance and error are shown in false colours with a legend", limit, async () => {
  const pixels = () => page.$eval("#canvas", (canvas) => canvas.toDataURL());
  const seen = new Set([await pixels()]);
  for (const [view, unit] of [["luminance", "cd/m²"], ["error", "± error"]]) {
    await page.click(`input[value=${view}]`);
    await page.waitForFunction((u) => document.querySelector("#view-legend").textContent.includes(u), {}, unit);
    seen.add(await pixels());
    assert.ok((await page.$$("#view-legend .ticks span")).length >= 2, view);
  }
  await page.click("input[value=photo]");
  await page.waitForSelector("#view-legend[hidden]");
  seen.add(await pixels());
  assert.equal(seen.size, 3);
});

test("a scene that cannot be read is an error at its place, and the page goes on", limit, async () => {
  await page.click('[data-path="broken.pbrt"]');
  await page.waitForFunction(() => document.querySelector("#scenes-note").textContent.includes("broken.pbrt:"));
  assert.match(await text("#scenes-note"), /broken\.pbrt:\d+:\d+: /);
  await click(30, 25);
  assert.ok(Number((await measured()).lux) > 0);
  complaints = complaints.filter((line) => !line.includes("400 (Bad Request)")); // the browser reports the refused call
});

test("a place without a surface says so", limit, async () => {
  await click(1, 1);
  await page.waitForFunction(() => document.querySelector("#result-error").textContent !== "");
  assert.equal(await text("#result-error"), "The camera sees no surface there.");
});

test("a server that is gone is reported, and found again with the levels of the lights", limit, async () => {
  const other = await startServer({ scenes, options: ["--load=lamps.pbrt"] });
  const front = await startGateway(other.address);
  await page.close();
  page = await open({ address: front.address });
  await slide('[data-light="1"] input[type=range]', 50);
  await page.waitForFunction((before) => document.querySelector("#picture").dataset.scene !== before, {}, await shownScene());
  await click(30, 25);
  const before = await measured();
  await other.stop("SIGKILL");
  await click(30, 26);
  await page.waitForSelector("#alert:not([hidden])");
  assert.match(await text("#alert"), /lucernad does not answer at .*tries again/i);
  assert.equal(await page.$eval("#server", (e) => e.dataset.state), "lost");

  // Forget what was there, so that only new answers count below.
  await page.$$eval("#picture, #result-point", (all) => all.forEach((e) => delete e.dataset.scene));
  await page.$eval("#result-point .big", (e) => e.remove());

  const again = await startServer({ scenes, listen: other.address });
  await page.waitForSelector("#alert[hidden]");
  await page.waitForFunction(() => document.querySelector("#server").dataset.state === "ready");
  await page.waitForSelector("#picture[data-scene]");
  await click(30, 25);
  const recovered = await measured();
  assert.equal(recovered.point, before.point);
  assert.equal(recovered.lux, before.lux);
  assert.equal(await page.$eval('[data-light="1"] input[type=range]', (e) => e.value), "50");

  // The gateway may be gone, too.
  await front.stop("SIGKILL");
  await click(30, 26);
  await page.waitForSelector("#alert:not([hidden])");
  assert.match(await text("#alert"), /gateway of this page does not answer/);
  await again.stop();
  // The browser itself reports each call that fails.
  complaints = complaints.filter((line) => !/Failed to load resource/.test(line));
});

test("a server that wants a token gets it from a form", limit, async () => {
  const { createHash } = await import("node:crypto");
  const token = "a-token-for-this-test-only";
  writeFileSync(`${scenes}/tokens.toml`, `[[token]]\nname = "viewer"\nsha256 = "${createHash("sha256").update(token).digest("hex")}"\nroles = ["query"]\n`);
  const guarded = await startServer({ scenes, options: ["--load=lamps.pbrt", `--token-file=${scenes}/tokens.toml`] });
  const front = await startGateway(guarded.address);
  await page.goto(front.address);
  await page.waitForSelector("#token-form:not([hidden])");
  await page.type("#token", "a-wrong-token-of-this-test");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelector("#token-error").textContent !== "");
  await page.$eval("#token", (input) => (input.value = ""));
  await page.type("#token", token);
  await page.keyboard.press("Enter");
  await page.waitForSelector("#picture[data-scene][data-map]");
  // This token may look, and not change anything.
  assert.match(await text("#lights-note"), /role load/);
  assert.ok(await page.$eval('[data-light="1"] input[type=range]', (e) => e.disabled));
  await click(30, 25);
  assert.ok(Number((await measured()).lux) > 0);
  complaints = complaints.filter((line) => !/Failed to load resource.*(401|403)/.test(line));
});

test("everything can be done with the keys", limit, async () => {
  const focus = () => page.evaluate(() => document.activeElement.id || document.activeElement.getAttribute("aria-label"));
  const tabTo = async (wanted) => {
    for (let i = 0; i < 40 && (await focus()) !== wanted; ++i) await page.keyboard.press("Tab");
    assert.equal(await focus(), wanted);
  };
  await tabTo("picture");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.down("Shift");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.up("Shift");
  await page.waitForFunction(() => /cd\/m², column \d+, row \d+/.test(document.querySelector("#spoken").textContent));
  assert.match(await text("#spoken"), /column 20, row 21$/); // from the middle, (30, 20)
  await page.keyboard.press("Enter");
  const first = await measured();
  await page.waitForFunction(() => document.querySelector("#spoken").textContent.includes("plus or minus"));
  assert.match(await text("#spoken"), /^[\d.]+ plus or minus [\d.]+ lux\. right /); // the nearer lamp
  await tabTo("Level of left");
  for (let i = 0; i < 5; ++i) await page.keyboard.press("PageDown");
  const before = await shownScene();
  await page.waitForFunction((id) => document.querySelector("#picture").dataset.scene !== id, {}, before);
  assert.ok(Number((await measured()).lux) < Number(first.lux));
  // Back to the picture, whose Escape clears the measurement.
  await page.focus("#picture");
  await page.keyboard.press("Escape");
  assert.ok(await page.$eval("#result-point", (e) => e.hidden));
});

test("roles and names of the accessibility tree", limit, async () => {
  await click(30, 25);
  await measured();
  const tree = await page.accessibility.snapshot();
  const all = [];
  const walk = (node) => {
    all.push(`${node.role} ${node.name ?? ""}`.trim());
    (node.children ?? []).forEach(walk);
  };
  walk(tree);
  for (const wanted of [
    "heading Lucerna", "heading Measurement", "heading Lights", "heading Scenes", "radio Point", "radio Grid", "radio Luminance",
    "slider Exposure", "slider Level of left", "switch left is on", "slider Measurements, relative error",
    "slider Picture, samples of a pixel", "button lamps.pbrt", "application Picture of lamps.pbrt",
  ])
    assert.ok(all.includes(wanted), `${wanted} is not in:\n${all.join("\n")}`);
});

for (const [width, height] of [[1280, 900], [400, 800]])
  for (const theme of ["dark", "light"])
    test(`no barrier and no sideways scrolling at ${width} pixels, ${theme}`, limit, async () => {
      await page.close();
      page = await open({ width, height, theme });
      await click(30, 25);
      await measured();
      await page.$$eval("details", (all) => all.forEach((e) => (e.open = true)));
      const sideways = await page.evaluate(() =>
        [...document.querySelectorAll("body *")]
          .filter((e) => e.getBoundingClientRect().right > innerWidth + 0.5 && !e.closest(".scroll, .hidden, .skip"))
          .map((e) => e.outerHTML.slice(0, 80)),
      );
      assert.deepEqual(sideways, []);
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width);
      await page.evaluate(require("axe-core").source);
      const { violations } = await page.evaluate(() => window.axe.run());
      assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`), []);
    });

test("the page loads nothing from other hosts", limit, async () => {
  const requested = new Set();
  page.on("request", (request) => requested.add(new URL(request.url()).host));
  await page.reload();
  await page.waitForSelector("#picture[data-scene][data-map]");
  assert.deepEqual([...requested], [new URL(gateway.address).host]);
});
