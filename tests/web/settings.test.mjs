// The settings of the gateway, and TLS on both of its sides.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import test, { after, before } from "node:test";

import { call, send } from "./calls.mjs";
import { certificates, Program, root, run, startGateway, startServer, stopAll } from "./programs.mjs";
import { makeScenes } from "./scene.mjs";

const limit = { timeout: 300_000 };
const folder = mkdtempSync(`${tmpdir()}/lucerna-settings.`);
const scenes = makeScenes();
let server;

before(async () => {
  server = await startServer({ scenes, options: ["--load=lamps.pbrt"] });
}, limit);

after(async () => {
  await stopAll();
  for (const made of [folder, scenes]) rmSync(made, { recursive: true });
});

test("TLS holds on both sides", limit, async () => {
  const path = await certificates(folder);
  const secure = await startServer({
    scenes,
    options: [
      `--tls-cert=${path("server.pem")}`,
      `--tls-key=${path("server.key")}`,
      `--tls-client-ca=${path("authority.pem")}`,
    ],
  });
  const certificate = [`--server-cert=${path("gateway.pem")}`, `--server-key=${path("gateway.key")}`];
  const front = [`--tls-cert=${path("gateway.pem")}`, `--tls-key=${path("gateway.key")}`];
  const ca = readFileSync(path("authority.pem"));
  const method = "AdminService/GetServerInfo";

  const good = await startGateway(secure.address, `--server-ca=${path("authority.pem")}`, ...certificate, ...front);
  assert.match(good.address, /^https:/);
  const answer = await call(good.address, method, {}, { ca });
  assert.equal(answer.status, 200, answer.text);
  await assert.rejects(call(good.address, method, {}, { ca: readFileSync(path("stranger.pem")) }), /certificate/);
  assert.equal((await send(good.address, { ca, headers: { Host: "evil.example" } })).status, 421);
  assert.equal(await good.stop(), 0);

  for (const [what, options] of [
    ["an unknown authority", [`--server-ca=${path("stranger.pem")}`, ...certificate]],
    ["no certificate of its own", [`--server-ca=${path("authority.pem")}`]],
    ["another name", [`--server-ca=${path("authority.pem")}`, ...certificate, "--server-name=other.example"]],
    ["no TLS", []],
  ]) {
    const bad = await startGateway(secure.address, ...options);
    const { status, text } = await call(bad.address, method);
    assert.equal(status, 503, `${what}: ${text}`);
    assert.match(JSON.parse(text).message, /lucernad does not answer/, what);
    await bad.stop();
  }
  await secure.stop();
});

test("wrong settings are refused with their name and what is allowed", limit, async () => {
  const program = `${root}build/web/lucerna-web.mjs`;
  for (const [options, words] of [
    [["--listen=0.0.0.0:0"], /listen = 0\.0\.0\.0:0, which other machines can reach; allowed: a loopback address/],
    [["--listen=127.0.0.1"], /listen = 127\.0\.0\.1, allowed: HOST:PORT/],
    [["--listen=::1:8080"], /listen = ::1:8080, allowed: HOST:PORT/],
    [["--listen=127.0.0.1:119537"], /listen = 127\.0\.0\.1:119537: port "119537", allowed: 0 to 65535/],
    [["--listen=[::1]:-1"], /listen = \[::1\]:-1: port "-1", allowed: 0 to 65535/],
    [["--server=127.0.0.1:65536"], /server = 127\.0\.0\.1:65536: port "65536", allowed: 1 to 65535/],
    [["--server=127.0.0.1:0"], /server = 127\.0\.0\.1:0: port "0", allowed: 1 to 65535/],
    [["--server=[::1]:http"], /server = \[::1\]:http: port "http", allowed: 1 to 65535/],
    [["--server=10.1.2.3:50051"], /server = 10\.1\.2\.3:50051, on another machine and without TLS; allowed: /],
    [["--tls-cert=/none"], /tls-cert and tls-key: one is missing/],
    [["--tls-cert=/none", "--tls-key=/none"], /tls-cert = \/none: ENOENT/],
    [["--server-name=a"], /need TLS to lucernad/],
    [["--max-calls=0"], /max-calls = 0, allowed: 1 to 65536/],
    [["--max-calls=many"], /max-calls = many, allowed: 1 to 65536/],
    [["--max-body-bytes=200000", "--max-message-bytes=100001"], /allowed: at least 2 times max-message-bytes = 100001/],
    [["--no-such"], /--no-such: no such option/],
    [["--token-file=/none"], /token-file = \/none: ENOENT/],
    [["--listen"], /--listen needs a value: HOST:PORT/],
  ]) {
    const { status, stderr } = await run(process.execPath, program, ...options);
    assert.equal(status, 2, `${options}: ${stderr}`);
    assert.match(stderr, words);
  }
  const { status, stdout } = await run(process.execPath, program, "--help");
  assert.equal(status, 0);
  assert.match(stdout, /--listen HOST:PORT=127\.0\.0\.1:8080 /);
});

test("the environment sets what flags do not", limit, async () => {
  const program = `${root}build/web/lucerna-web.mjs`;
  const environment = {
    LUCERNA_WEB_LISTEN: "127.0.0.1:0",
    LUCERNA_WEB_SERVER: server.address,
    LUCERNA_WEB_MAX_CALLS: "0",
  };
  const started = await Program.start(process.execPath, [program, "--max-calls=2"], environment);
  assert.equal((await call(started.address, "AdminService/GetServerInfo")).status, 200);
  assert.equal(await started.stop(), 0);
  await assert.rejects(Program.start(process.execPath, [program], environment), /max-calls = 0, allowed/);
});
