// The page with the keys, for screen readers, in narrow windows, and offline.
import assert from "node:assert/strict";
import test from "node:test";

import { click, gateway, limit, measured, page, reopen, shownScene, text } from "./opened_page.mjs";
import { require } from "./programs.mjs";

test("everything can be done with the keys", limit, async () => {
  const focus = () =>
    page.evaluate(() => document.activeElement.id || document.activeElement.getAttribute("aria-label"));
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
    "heading Lucerna",
    "heading Measurement",
    "heading Lights",
    "heading Scenes",
    "radio Point",
    "radio Grid",
    "radio Luminance",
    "slider Exposure",
    "slider Level of left",
    "switch left is on",
    "slider Measurements, relative error",
    "slider Picture, samples of a pixel",
    "button lamps.pbrt",
    "application Picture of lamps.pbrt",
  ])
    assert.ok(all.includes(wanted), `${wanted} is not in:\n${all.join("\n")}`);
});

for (const [width, height] of [
  [1280, 900],
  [400, 800],
])
  for (const theme of ["dark", "light"])
    test(`no barrier and no sideways scrolling at ${width} pixels, ${theme}`, limit, async () => {
      await reopen({ width, height, theme });
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
      assert.deepEqual(
        violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`),
        [],
      );
    });

test("the page loads nothing from other hosts", limit, async () => {
  const requested = new Set();
  page.on("request", (request) => requested.add(new URL(request.url()).host));
  await page.reload();
  await page.waitForSelector("#picture[data-scene][data-map]");
  assert.deepEqual([...requested], [new URL(gateway.address).host]);
});
