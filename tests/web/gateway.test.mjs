// The gateway: what it passes on, and what it refuses.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import test, { after, before } from "node:test";

import { call, send } from "./calls.mjs";
import { startGateway, startServer, stopAll, until } from "./programs.mjs";
import { makeScenes } from "./scene.mjs";

const limit = { timeout: 300_000 };
const folder = mkdtempSync(`${tmpdir()}/lucerna-gateway.`);
const scenes = makeScenes();
let server;
let gateway;

before(async () => {
  server = await startServer({ scenes, options: ["--load=lamps.pbrt"] });
  gateway = await startGateway(server.address);
}, limit);

after(async () => {
  await stopAll();
  for (const made of [folder, scenes]) rmSync(made, { recursive: true });
});

/** The calls that the server computes now in its bulk lane. */
const bulk = async () => JSON.parse((await call(gateway.address, "AdminService/GetStats")).text).bulkRequests ?? 0;

test("calls reach the server, and its answers come back", limit, async () => {
  const info = await call(gateway.address, "AdminService/GetServerInfo");
  assert.equal(info.status, 200, info.text);
  assert.match(JSON.parse(info.text).version, /^\d+\.\d+\.\d+$/);
  const { scenes: loaded } = JSON.parse((await call(gateway.address, "SceneService/ListScenes")).text);
  assert.equal(loaded[0].path, "lamps.pbrt");
});

test("errors keep their code, their text and their details", limit, async () => {
  const missing = await call(gateway.address, "SceneService/ListLights", { sceneId: "0".repeat(64) });
  assert.equal(missing.status, 404);
  const { code, message, details } = JSON.parse(missing.text);
  assert.equal(code, "not_found");
  assert.match(message, /no scene with this id|not loaded/);
  assert.deepEqual(
    details.map(({ type }) => type),
    ["google.rpc.ErrorInfo"],
  );
  assert.ok(Buffer.from(details[0].value, "base64").includes("SCENE_NOT_LOADED"));
});

test("a picture comes as a stream", limit, async () => {
  const { scenes: loaded } = JSON.parse((await call(gateway.address, "SceneService/ListScenes")).text);
  const message = JSON.stringify({
    sceneId: loaded[0].sceneId,
    accuracy: { samples: 2 },
    samplesPerBlock: 1,
    tileSize: 40,
  });
  const head = Buffer.alloc(5);
  head.writeUInt32BE(message.length, 1);
  const answer = await send(gateway.address, {
    path: "/lucerna.v1.RenderService/RenderImage",
    method: "POST",
    headers: { "Content-Type": "application/connect+json" },
    body: Buffer.concat([head, Buffer.from(message)]),
  });
  assert.equal(answer.status, 200);
  // Two tiles of 40 pixels and less, with 1 and with 2 samples; then the end of the stream, without an error.
  assert.equal(answer.text.match(/"samplesDone"/g).length, 4);
  assert.match(answer.text, /\{\}$/);
});

test("an uploaded file comes as a stream of requests", limit, async () => {
  const content = Buffer.from("# an asset\n");
  const parts = [
    { header: { sha256: createHash("sha256").update(content).digest("base64"), sizeBytes: String(content.length) } },
    { chunk: content.toString("base64") },
  ].map((part) => {
    const text = Buffer.from(JSON.stringify(part)),
      head = Buffer.alloc(5);
    head.writeUInt32BE(text.length, 1);
    return Buffer.concat([head, text]);
  });
  const answer = await send(gateway.address, {
    path: "/lucerna.v1.SceneService/UploadAsset",
    method: "POST",
    headers: { "Content-Type": "application/connect+json" },
    body: Buffer.concat(parts),
  });
  assert.match(answer.text, new RegExp(`"receivedBytes":"${content.length}"`));
});

test("the page has strict headers, and nothing else is served", limit, async () => {
  const page = await send(gateway.address);
  assert.equal(page.status, 200);
  assert.match(page.headers["content-type"], /^text\/html/);
  for (const path of ["/", "/page.js", "/page.css", "/icon.svg", "/none"]) {
    const { headers } = await send(gateway.address, { path });
    const policy = headers["content-security-policy"];
    assert.match(policy, /default-src 'none'/, path);
    assert.match(policy, /script-src 'self';/, path);
    assert.doesNotMatch(policy, /unsafe/, path);
    assert.equal(headers["x-content-type-options"], "nosniff", path);
    assert.equal(headers["access-control-allow-origin"], undefined, path);
  }
  assert.doesNotMatch(page.text, /<script(?![^>]*src=)|\son[a-z]+=|style="/);
  for (const path of ["/lucerna-web.mjs", "/../lucerna-web.mjs", "/..%2flucerna-web.mjs", "/site/page.js", "/%00"])
    assert.equal((await send(gateway.address, { path })).status, 404, path);
  assert.equal((await send(gateway.address, { method: "DELETE" })).status, 405);
  const again = await send(gateway.address, { headers: { "If-None-Match": page.headers.etag } });
  assert.equal(again.status, 304);
  assert.equal(again.text, "");
});

test("a foreign Host is refused", limit, async () => {
  const { port } = new URL(gateway.address);
  for (const host of [
    "evil.example",
    `evil.example:${port}`,
    "127.0.0.1.evil.example",
    "127.0.0.1@evil.example",
    "10.0.0.1",
  ]) {
    for (const path of ["/", "/health", "/lucerna.v1.AdminService/GetServerInfo"]) {
      const { status, text } = await send(gateway.address, { path, headers: { Host: host } });
      assert.equal(status, 421, `${host} ${path}`);
      assert.match(text, /allowed: /);
    }
  }
  for (const host of [`127.0.0.1:${port}`, `localhost:${port}`, `[::1]:${port}`])
    assert.equal((await send(gateway.address, { headers: { Host: host } })).status, 200, host);
  const named = await startGateway(server.address, "--name=lamps.example");
  assert.equal((await send(named.address, { headers: { Host: "lamps.example" } })).status, 200);
  assert.equal((await send(named.address, { headers: { Host: "other.example" } })).status, 421);
  await named.stop();
});

test("calls of pages of other sites are refused", limit, async () => {
  const method = "AdminService/GetServerInfo",
    { host } = new URL(gateway.address);
  for (const headers of [
    { Origin: "https://evil.example" },
    { Origin: "null" },
    { Origin: "http://127.0.0.1:1" },
    { Origin: `http://${host}.evil.example` },
    { "Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors" },
  ]) {
    const { status, text } = await call(gateway.address, method, {}, { headers });
    assert.equal(status, 403, JSON.stringify(headers));
    assert.match(text, /allowed: /);
  }
  assert.equal((await call(gateway.address, method, {}, { headers: { Origin: `http://${host}` } })).status, 200);
});

test("a request over the limit is refused, and the next one is answered", limit, async () => {
  const small = await startGateway(server.address, "--max-message-bytes=65536");
  const places = Array(60_000).fill(1);
  const large = await call(small.address, "RenderService/FindSurfaces", { sceneId: "x", places });
  assert.equal(large.status, 429, large.text);
  assert.match(JSON.parse(large.text).message, /65536/);
  assert.equal((await call(small.address, "AdminService/GetServerInfo")).status, 200);
  await small.stop();
});

test("requests that are no messages are refused", limit, async () => {
  const wrong = await call(gateway.address, "AdminService/GetServerInfo", "{ not JSON");
  assert.equal(wrong.status, 400);
  assert.equal((await call(gateway.address, "AdminService/NoSuchCall")).status, 404);
  assert.equal((await call(gateway.address, "AdminService/GetServerInfo")).status, 200);
});

test("more calls at once than allowed are refused", limit, async () => {
  const narrow = await startGateway(server.address, "--max-calls=1");
  const { scenes: loaded } = JSON.parse((await call(narrow.address, "SceneService/ListScenes")).text);
  // Enough work that both calls are there at once.
  const request = { sceneId: loaded[0].sceneId, rect: { x1: 60, y1: 40 }, accuracy: { samples: 1024 } };
  const answers = await Promise.all([1, 2, 3].map(() => call(narrow.address, "RenderService/RenderTile", request)));
  const refused = answers.filter(({ status }) => status === 429);
  assert.equal(answers.filter(({ status }) => status === 200).length, 1);
  assert.equal(refused.length, 2);
  assert.match(JSON.parse(refused[0].text).message, /calls at once = 2, allowed: 1/);
  assert.equal((await call(narrow.address, "AdminService/GetServerInfo")).status, 200);
  await narrow.stop();
});

test("a call ends when the browser leaves", limit, async () => {
  const { scenes: loaded } = JSON.parse((await call(gateway.address, "SceneService/ListScenes")).text);
  const body = JSON.stringify({ sceneId: loaded[0].sceneId, rect: { x1: 60, y1: 40 }, accuracy: { samples: 1 << 18 } });
  const { hostname, port, host } = new URL(gateway.address);
  const socket = connect(Number(port), hostname);
  socket.on("error", () => {});
  socket.write(
    `POST /lucerna.v1.RenderService/RenderTile HTTP/1.1\r\nHost: ${host}\r\nContent-Type: application/json\r\n` +
      `Content-Length: ${body.length}\r\n\r\n${body}`,
  );
  // The tile would take hours.  No time is asserted: the limit of the test ends a wait without end.
  await until(async () => (await bulk()) === 1);
  socket.destroy();
  await until(async () => (await bulk()) === 0);
});

test("health says whether the server serves", limit, async () => {
  const here = await send(gateway.address, { path: "/health" });
  assert.equal(here.status, 200);
  assert.deepEqual(JSON.parse(here.text), { status: "SERVING" });
  const alone = await startGateway("127.0.0.1:1");
  const gone = await send(alone.address, { path: "/health" });
  assert.equal(gone.status, 503);
  assert.match(JSON.parse(gone.text).message, /lucernad does not answer at 127\.0\.0\.1:1/);
  const lost = await call(alone.address, "AdminService/GetServerInfo");
  assert.equal(lost.status, 503);
  assert.equal(JSON.parse(lost.text).code, "unavailable");
  await alone.stop();
});

test("tokens of callers are passed on, and those of a file stand in", limit, async () => {
  const token = "a-token-for-this-test-only";
  writeFileSync(
    `${folder}/tokens.toml`,
    `[[token]]\nname = "viewer"\nsha256 = "${createHash("sha256").update(token).digest("hex")}"\nroles = ["query"]\n`,
  );
  writeFileSync(`${folder}/viewer.token`, `${token}\n`);
  const guarded = await startServer({ scenes, options: [`--token-file=${folder}/tokens.toml`] });
  const bare = await startGateway(guarded.address),
    holder = await startGateway(guarded.address, `--token-file=${folder}/viewer.token`);
  const method = "SceneService/ListScenes",
    bearer = (text) => ({ headers: { Authorization: `Bearer ${text}` } });
  assert.equal((await call(bare.address, method)).status, 401);
  assert.equal((await call(bare.address, method, {}, bearer("a-wrong-token-of-this-test"))).status, 401);
  assert.equal((await call(bare.address, method, {}, bearer(token))).status, 200);
  assert.equal((await call(holder.address, method)).status, 200);
  // A caller with a token of its own does not get the rights of the file's.
  assert.equal((await call(holder.address, method, {}, bearer("a-wrong-token-of-this-test"))).status, 401);
  const denied = await call(holder.address, "SceneService/LoadScene", { path: "lamps.pbrt" });
  assert.equal(denied.status, 403);
  assert.match(JSON.parse(denied.text).message, /needs the role load/);
  assert.doesNotMatch(bare.output + holder.output, new RegExp(token));
  for (const program of [bare, holder, guarded]) await program.stop();
});

test("SIGTERM lets running calls finish, and takes no others", limit, async () => {
  const ending = await startGateway(server.address, "--drain-seconds=300");
  const { scenes: loaded } = JSON.parse((await call(ending.address, "SceneService/ListScenes")).text);
  const running = call(ending.address, "RenderService/RenderTile", {
    sceneId: loaded[0].sceneId,
    rect: { x1: 60, y1: 40 },
    accuracy: { samples: 4096 },
  });
  await until(async () => (await bulk()) > 0);
  const status = ending.stop();
  await until(() => ending.output.includes("draining"));
  await assert.rejects(call(ending.address, "AdminService/GetServerInfo"), /ECONNREFUSED/);
  assert.equal((await running).status, 200);
  assert.equal(await status, 0);
});

test("calls that outlast the drain are ended with a reason", limit, async () => {
  const ending = await startGateway(server.address, "--drain-seconds=0");
  const { scenes: loaded } = JSON.parse((await call(ending.address, "SceneService/ListScenes")).text);
  const running = call(ending.address, "RenderService/RenderTile", {
    sceneId: loaded[0].sceneId,
    rect: { x1: 60, y1: 40 },
    accuracy: { samples: 1 << 18 },
  });
  await until(async () => (await bulk()) > 0);
  const status = ending.stop();
  const { text } = await running;
  assert.match(JSON.parse(text).message, /the gateway is stopping|shutting down/i, text);
  assert.equal(await status, 0);
  await until(async () => (await bulk()) === 0);
});
