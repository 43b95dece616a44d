// Connections of browsers that take places and memory, and send no calls.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { connect as connectHttp2 } from "node:http2";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import test, { after, before } from "node:test";
import { connect as connectTls } from "node:tls";
import { gzipSync } from "node:zlib";

import { call } from "./calls.mjs";
import { certificates, startGateway, startServer, stopAll, until } from "./programs.mjs";
import { makeScenes } from "./scene.mjs";

const limit = { timeout: 300_000 };
const folder = mkdtempSync(`${tmpdir()}/lucerna-connections.`);
const scenes = makeScenes();
const method = "AdminService/GetServerInfo";
let server;
let sceneId;
let ca;
let tls;

before(async () => {
  server = await startServer({ scenes, options: ["--load=lamps.pbrt"] });
  const path = await certificates(folder);
  ca = readFileSync(path("authority.pem"));
  tls = [`--tls-cert=${path("gateway.pem")}`, `--tls-key=${path("gateway.key")}`];
  const gateway = await startGateway(server.address);
  sceneId = JSON.parse((await call(gateway.address, "SceneService/ListScenes")).text).scenes[0].sceneId;
  await gateway.stop();
}, limit);

after(async () => {
  await stopAll();
  for (const made of [folder, scenes]) rmSync(made, { recursive: true });
});

const opened = [];
/** Notes in `gone` whether a socket or a session is closed.  The end of a test closes those that stay. */
function watched(connection) {
  connection.gone = false;
  connection.on("error", () => {});
  connection.on("close", () => (connection.gone = true));
  connection.resume?.();
  opened.push(connection);
  return connection;
}
test.afterEach(() => opened.splice(0).forEach((connection) => connection.destroy()));

/** A connection that sends `text` and no more. */
function open(gateway, text = "") {
  const { hostname, port } = new URL(gateway.address);
  const socket = watched(connect(Number(port), hostname));
  socket.write(text);
  return new Promise((resolve) => socket.once("connect", () => resolve(socket)));
}

/** An HTTP/2 session that the server has answered. */
async function session(gateway) {
  const { port } = new URL(gateway.address);
  const made = watched(connectHttp2(`https://localhost:${port}`, { ca }));
  await new Promise((resolve) => made.once("remoteSettings", resolve));
  return made;
}

const head = (gateway, name, length, type = "application/json") =>
  `POST /lucerna.v1.${name} HTTP/1.1\r\nHost: ${new URL(gateway.address).host}\r\nContent-Type: ${type}\r\n` +
  `Content-Length: ${length}\r\n\r\n`;

const gone = (connections) => connections.filter((connection) => connection.gone).length;

// Would take hours.
const endless = () => JSON.stringify({ sceneId, rect: { x1: 60, y1: 40 }, accuracy: { samples: 1 << 18 } });
const bulk = async (gateway) =>
  JSON.parse((await call(gateway.address, "AdminService/GetStats")).text).bulkRequests ?? 0;

test("silent connections make place for new ones", limit, async () => {
  const gateway = await startGateway(server.address, "--max-connections=8");
  for (const text of ["", "POST / HTTP/1.1\r\nHost:", head(gateway, method, 1000) + "{"]) {
    const silent = [];
    for (let i = 0; i < 8; ++i) silent.push(await open(gateway, text));
    assert.equal((await call(gateway.address, method)).status, 200);
    await until(() => gone(silent) > 0);
  }
  await gateway.stop();
});

test("connections whose calls run keep their places", limit, async () => {
  const gateway = await startGateway(server.address, "--max-connections=3"),
    other = await startGateway(server.address);
  const body = endless();
  const request = head(gateway, "RenderService/RenderTile", body.length) + body;
  const busy = [];
  for (let i = 0; i < 3; ++i) busy.push(await open(gateway, request));
  await until(async () => (await bulk(other)) === 3);
  await assert.rejects(call(gateway.address, method), /ECONNRESET|socket hang up/);
  assert.equal(gone(busy), 0);
  busy.forEach((socket) => socket.destroy());
  await until(async () => (await bulk(other)) === 0);
  assert.equal((await call(gateway.address, method)).status, 200);
  await gateway.stop();
  await other.stop();
});

test("silent connections are closed, and those whose calls run are not", limit, async () => {
  const gateway = await startGateway(server.address, "--idle-seconds=1"),
    secure = await startGateway(server.address, "--idle-seconds=1", ...tls);
  const body = endless();
  const busy = await open(gateway, head(gateway, "RenderService/RenderTile", body.length) + body);
  const busySession = await session(secure);
  const post = { ":method": "POST", "content-type": "application/json" };
  watched(busySession.request({ ...post, ":path": "/lucerna.v1.RenderService/RenderTile" })).end(body);
  await until(async () => (await bulk(gateway)) === 2);

  const { port } = new URL(secure.address);
  const half = await session(secure);
  watched(half.request({ ...post, ":path": `/lucerna.v1.${method}` })).write("{");
  const silent = [
    await open(gateway),
    await open(gateway, head(gateway, method, 1000) + "{"),
    await open(gateway, head(gateway, "SceneService/UploadAsset", 1000, "application/connect+json")),
    await open(secure), // no handshake
    watched(connectTls({ host: "127.0.0.1", port, ca, servername: "localhost" })), // no request of HTTP/1
    await session(secure),
    half,
  ];
  await until(() => gone(silent) === silent.length);
  assert.equal(gone([busy, busySession]), 0);
  assert.equal(await bulk(gateway), 2);
  for (const program of [gateway, secure]) await program.stop("SIGKILL");
});

test("bodies that do not end hold a bounded number of bytes", limit, async () => {
  const options = ["--max-message-bytes=1048576", "--max-body-bytes=4194304"];
  const gateway = await startGateway(server.address, ...options),
    secure = await startGateway(server.address, ...options, ...tls);
  const part = " ".repeat(1_000_000);
  const half = [];
  for (let i = 0; i < 20; ++i) half.push(await open(gateway, head(gateway, method, part.length + 1) + part));
  await until(() => gone(half) >= 16);
  // Whoever sends a whole message is answered.
  assert.equal((await call(gateway.address, method, `{${part.slice(0, 900_000)}}`)).status, 200);

  // The same by streams of one connection.
  const many = await session(secure);
  for (let i = 0; i < 20; ++i) {
    const stream = watched(
      many.request({ ":method": "POST", ":path": `/lucerna.v1.${method}`, "content-type": "application/json" }),
    );
    stream.write(part);
  }
  await until(() => many.gone);
  assert.equal((await call(secure.address, method, `{${part.slice(0, 900_000)}}`, { ca })).status, 200);
  for (const program of [gateway, secure]) assert.equal(await program.stop(), 0);
});

test("an upload of many messages counts each message by itself", limit, async () => {
  const gateway = await startGateway(server.address, "--max-message-bytes=65536", "--max-body-bytes=131072");
  const enveloped = (message) => {
    const text = Buffer.from(JSON.stringify(message)),
      start = Buffer.alloc(5);
    start.writeUInt32BE(text.length, 1);
    return Buffer.concat([start, text]);
  };
  const content = Buffer.alloc(1_000_000, "#");
  const sha256 = createHash("sha256").update(content).digest("base64");
  const parts = [enveloped({ header: { sha256, sizeBytes: String(content.length) } })];
  for (let at = 0; at < content.length; at += 40_000)
    parts.push(enveloped({ chunk: content.subarray(at, at + 40_000).toString("base64") }));
  const { status, text } = await call(gateway.address, "SceneService/UploadAsset", Buffer.concat(parts), {
    headers: { "Content-Type": "application/connect+json" },
  });
  assert.equal(status, 200, text);
  assert.match(text, /"receivedBytes":"1000000"/);
  await gateway.stop();
});

test("silent uploads make place for other calls", limit, async () => {
  const gateway = await startGateway(server.address, "--max-calls=2");
  const upload = head(gateway, "SceneService/UploadAsset", 1000, "application/connect+json");
  const silent = [await open(gateway, upload), await open(gateway, upload)];
  await until(async () => (await call(gateway.address, method)).status === 200);
  await until(() => gone(silent) > 0);
  await gateway.stop();
});

test("answers that nobody reads hold a bounded number of bytes", limit, async () => {
  const gateway = await startGateway(server.address, "--max-body-bytes=33554432", "--max-message-bytes=16777216");
  // An answer of 12 MB is larger than what the kernel takes.
  const offsetsM = Array(3 * 65536).fill(0.3);
  const body = JSON.stringify({ sceneId, receivers: { offsetsM }, accuracy: { samples: 1 } });
  assert.ok((await call(gateway.address, "LightingService/SampleLi", body)).text.length > 10_000_000);
  for (let i = 0; i < 4; ++i)
    (await open(gateway, head(gateway, "LightingService/SampleLi", body.length) + body)).pause();
  await until(() => gateway.output.includes("closed a connection"));
  assert.equal((await call(gateway.address, method)).status, 200);
  await gateway.stop("SIGKILL");
});

test("compressed requests are refused", limit, async () => {
  const gateway = await startGateway(server.address);
  for (const [header, type] of [
    ["Content-Encoding", "application/json"],
    ["Connect-Content-Encoding", "application/connect+json"],
    ["Grpc-Encoding", "application/grpc-web+proto"],
  ]) {
    const { status, text } = await call(gateway.address, method, gzipSync("{}"), {
      headers: { [header]: "gzip", "Content-Type": type },
    });
    assert.equal(status, 415, `${header}: ${text}`);
    assert.match(text, /gzip, allowed: identity/);
  }
  await gateway.stop();
});
