// The page in Debian's Chromium, with a server and a gateway of its own for each file of tests.
import assert from "node:assert/strict";
import { rmSync } from "node:fs";
import { after, afterEach, before, beforeEach } from "node:test";

import { lucerna, startBrowser, startGateway, startServer, stopAll } from "./programs.mjs";
import { makeScenes } from "./scene.mjs";

export const limit = { timeout: 600_000 };
export const scenes = makeScenes();
export let server;
export let gateway;
let chromium;
export let page;
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

export const text = (selector) => page.$eval(selector, (e) => e.textContent.trim());
/** The scene that the picture shows now. */
export const shownScene = () => page.$eval("#picture", (e) => e.dataset.scene);

/** Clicks on the middle of a pixel of the picture, of 60 x 40. */
export async function click(x, y) {
  const box = await page.$eval("#canvas", (canvas) => {
    canvas.scrollIntoView({ block: "center" });
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return { left, top, width, height };
  });
  await page.mouse.click(box.left + ((x + 0.5) / 60) * box.width, box.top + ((y + 0.5) / 40) * box.height);
}

/** Waits until the measurement of the scene of now is there, and returns its numbers. */
export async function measured(selector = "#result-point") {
  await page.waitForFunction(
    (box, picture) => {
      const { dataset, ariaBusy, hidden } = document.querySelector(box);
      return (
        !hidden &&
        dataset.error &&
        dataset.scene &&
        ariaBusy === "false" &&
        dataset.scene === document.querySelector(picture).dataset.scene
      );
    },
    {},
    selector,
    "#picture",
  );
  return page.$eval(selector, (box) => {
    const big = box.querySelector(".big");
    return {
      ...big.dataset,
      shown: big.textContent,
      command: box.querySelector("code")?.textContent,
      places: JSON.parse(box.dataset.places),
    };
  });
}

/** The illuminance that `lucerna` gives for the command that the page shows. */
export async function answerOf(command) {
  const words = command.split(" ");
  assert.deepEqual(words.slice(0, 2), ["lucerna", "irradiance"]);
  return JSON.parse(await lucerna(server.address, "--json", ...words.slice(1)));
}

/** Sets a slider as a user's hand does. */
export const slide = (selector, value) =>
  page.$eval(
    selector,
    (slider, to) => {
      slider.value = to;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      slider.dispatchEvent(new Event("change", { bubbles: true }));
    },
    String(value),
  );

/** Opens the page again, in another size or theme, or that of another gateway. */
export async function reopen(options) {
  await page.close();
  page = await open(options);
}

/** Leaves out what the browser itself reports about calls that fail. */
export function forgive(pattern) {
  complaints = complaints.filter((line) => !pattern.test(line));
}
