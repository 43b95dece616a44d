// What a user of the page sees and does.  Numbers are compared with those of `lucerna`.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import test from "node:test";

import { grid as gridOf } from "../../deploy/web/page/geometry.js";
import { answerOf, click, limit, measured, page, scenes, server, shownScene, slide, text } from "./opened_page.mjs";
import { lucerna } from "./programs.mjs";

test("the scene, its lights and its picture appear", limit, async () => {
  assert.match(await page.title(), /^lamps\.pbrt/);
  assert.match(await text("#server"), /^lucernad \d+\.\d+\.\d+, \d+ threads$/);
  const names = await page.$$eval("#scenes button", (buttons) => buttons.map((b) => [b.textContent, b.ariaCurrent]));
  assert.deepEqual(names, [
    ["lamps.pbrt", "true"],
    ["broken.pbrt", "false"],
  ]);
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
  assert.ok(
    Math.abs(error - (answer.upperLx[0] - answer.lowerLx[0]) / 2) <= 0.06 * error,
    `${shown}: ${answer.lowerLx[0]} to ${answer.upperLx[0]}`,
  );
  // The bars: each light's direct light, and the rest.
  const bars = Object.fromEntries(
    await page.$$eval(".bars li", (rows) =>
      rows.map((row) => [
        row.querySelector(".bar-name").textContent,
        parseFloat(row.querySelector(".bar-value").textContent),
      ]),
    ),
  );
  const direct = answer.shares.map(({ illuminanceLx }) => illuminanceLx[0]);
  const rounding = 0.005;
  for (const [name, lux] of [
    ["left", direct[0]],
    ["right", direct[1]],
    ["Reflected light", answer.illuminanceLx[0] - direct[0] - direct[1]],
  ])
    assert.ok(Math.abs(bars[name] - lux) <= rounding * lux + 1e-3, `${name}: ${bars[name]}, not ${lux}`);
});

test("the number of the direct light is that of the formula", limit, async () => {
  await click(30, 25);
  const { point } = await measured();
  const [x, y, z] = point.split(",").map(Number);
  const bars = await page.$$eval(".bars li", (rows) =>
    rows.map((row) => [
      row.querySelector(".bar-name").textContent,
      parseFloat(row.querySelector(".bar-value").textContent),
    ]),
  );
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
  for (const [x, y] of [
    [5, 35],
    [30, 25],
    [42, 20],
    [59, 39],
  ]) {
    await page.mouse.move(box.left + ((x + 0.5) / 60) * box.width, box.top + ((y + 0.5) / 40) * box.height);
    const shown = await page.$eval("#hover", (e) => [e.textContent, Number(e.dataset.luminance)]);
    const at = start + 12 * ((39 - y) * 60 + x);
    const luminance =
      0.2126 * bytes.readFloatLE(at) + 0.7152 * bytes.readFloatLE(at + 4) + 0.0722 * bytes.readFloatLE(at + 8);
    assert.ok(Math.abs(shown[1] - luminance) <= 1e-5 * luminance, `pixel ${x}, ${y}: ${shown[1]}, not ${luminance}`);
    assert.match(shown[0], /^[\d.]+ cd\/m²$/);
  }
});

test("half the level of the only light halves the number", limit, async () => {
  await page.click('[data-light="2"] input[role=switch]');
  await page.waitForFunction(
    (before) => document.querySelector("#picture").dataset.scene !== before,
    {},
    await shownScene(),
  );
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
  const answer = JSON.parse(
    await lucerna(
      server.address,
      "--json",
      "irradiance",
      "lamps.pbrt",
      `--points=${scenes}/points.csv`,
      "--normal=0,0,1",
      "--error=0.5%",
    ),
  );
  some.forEach((i, k) => {
    // Rows of the table are from the top of the plan.
    const shown = cells[(rows - 1 - Math.floor(i / columns)) * columns + (i % columns)],
      lux = answer.illuminanceLx[k];
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
  assert.deepEqual(
    times.map((time) => time !== "–"),
    [false, false, false, true, true, false],
  );
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
  for (const [view, unit] of [
    ["luminance", "cd/m²"],
    ["error", "± error"],
  ]) {
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
