// What the page says when something fails.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { writeFileSync } from "node:fs";
import test from "node:test";

import {
  click,
  forgive,
  gateway,
  limit,
  measured,
  page,
  reopen,
  scenes,
  server,
  shownScene,
  slide,
  text,
} from "./opened_page.mjs";
import { startGateway, startServer } from "./programs.mjs";

test("a scene that cannot be read is an error at its place, and the page goes on", limit, async () => {
  await page.click('[data-path="broken.pbrt"]');
  await page.waitForFunction(() => document.querySelector("#scenes-note").textContent.includes("broken.pbrt:"));
  assert.match(await text("#scenes-note"), /broken\.pbrt:\d+:\d+: /);
  await click(30, 25);
  assert.ok(Number((await measured()).lux) > 0);
  forgive(/400 \(Bad Request\)/); // the browser reports the refused call
});

test("a place without a surface says so", limit, async () => {
  await click(1, 1);
  await page.waitForFunction(() => document.querySelector("#result-error").textContent !== "");
  assert.equal(await text("#result-error"), "The camera sees no surface there.");
});

test("a server that is gone is reported, and found again with the levels of the lights", limit, async () => {
  const other = await startServer({ scenes, options: ["--load=lamps.pbrt"] });
  const front = await startGateway(other.address);
  await reopen({ address: front.address });
  await slide('[data-light="1"] input[type=range]', 50);
  await page.waitForFunction(
    (before) => document.querySelector("#picture").dataset.scene !== before,
    {},
    await shownScene(),
  );
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
  forgive(/Failed to load resource/);
});

test("a server that wants a token gets it from a form", limit, async () => {
  const token = "a-token-for-this-test-only";
  writeFileSync(
    `${scenes}/tokens.toml`,
    `[[token]]\nname = "viewer"\nsha256 = "${createHash("sha256").update(token).digest("hex")}"\nroles = ["query"]\n`,
  );
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
  forgive(/Failed to load resource.*(401|403)/);
});
