// `make web` starts both programs, and stops both.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import test from "node:test";

import { root, until } from "./programs.mjs";

const limit = { timeout: 300_000 };

/** Starts the script, in a group of its own as a terminal does, and waits for its address. */
async function start() {
  const script = spawn(`${root}deploy/web/run.sh`, [`${root}build/release`, "127.0.0.1:0"], {
    detached: true,
    stdio: ["ignore", "pipe", "pipe"],
  });
  const kill = () => process.kill(-script.pid, "SIGKILL");
  process.once("exit", kill);
  let output = "";
  for (const stream of [script.stdout, script.stderr]) stream.on("data", (text) => (output += text));
  const ended = new Promise((resolve) => script.once("exit", (status) => resolve(status)));
  ended.then(() => process.off("exit", kill));
  await until(() => /Open http\S+/.test(output) || script.exitCode !== null);
  return { script, ended, address: /Open (http\S+)/.exec(output)?.[1], output: () => output };
}

/** Whether something listens there. */
const answers = (address) =>
  fetch(`${address}/health`).then(
    (answer) => answer.ok,
    () => false,
  );

test("both programs start with the demo scene, and Ctrl-C stops both", limit, async () => {
  for (const [signal, status] of [
    ["SIGINT", 130],
    ["SIGTERM", 143],
  ]) {
    const { script, ended, address, output } = await start();
    assert.ok(address, output());
    assert.ok(await answers(address));
    const call = (method) =>
      fetch(`${address}/lucerna.v1.${method}`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: "{}",
      });
    const { scenes } = await (await call("SceneService/ListScenes")).json();
    assert.equal(scenes[0].path, "demo.pbrt");
    // The terminal sends Ctrl-C to the whole group.
    process.kill(-script.pid, signal);
    assert.equal(await ended, status);
    assert.equal(await answers(address), false);
  }
});

test("an address that other machines reach is refused", limit, async () => {
  const script = spawn(`${root}deploy/web/run.sh`, [`${root}build/release`, "0.0.0.0:0"], {
    stdio: ["ignore", "ignore", "pipe"],
  });
  let errors = "";
  script.stderr.on("data", (text) => (errors += text));
  assert.equal(await new Promise((resolve) => script.once("close", resolve)), 1);
  assert.match(errors, /listen = 0\.0\.0\.0:0, which other machines can reach/);
});
