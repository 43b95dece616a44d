// lucerna-web: serves the page, and passes the calls of browsers on to lucernad.
import { createServer } from "node:http";
import { createSecureServer } from "node:http2";
import { fileURLToPath } from "node:url";

import { ConnectError, createContextValues } from "@connectrpc/connect";
import { connectNodeAdapter } from "@connectrpc/connect-node";

import { Connections } from "./connections.js";
import { compressed, guard } from "./guard.js";
import { proxy, requestKey } from "./proxy.js";
import { address, content, help, readSettings, SettingError } from "./settings.js";
import { answer, site } from "./site.js";

/** @typedef {import("./settings.js").Settings} Settings */

/** Logs a line in the form of lucernad. */
function log(/** @type {string} */ level, /** @type {string} */ text) {
  process.stderr.write(`${new Date().toISOString().replace("Z", "+00:00")} [${level}] ${text}\n`);
}

/**
 * The handler of all requests.
 * @param {Settings} settings
 * @param {AbortSignal} stop
 * @param {Connections} connections
 */
function handler(settings, stop, connections) {
  const calls = proxy(settings, stop, connections);
  const refusal = guard([address("listen", settings.listen).host, ...settings.name]);
  const page = site(fileURLToPath(new URL("site", import.meta.url)));
  const connect = connectNodeAdapter({
    routes: calls.routes,
    fallback: page,
    readMaxBytes: settings.maxMessageBytes,
    writeMaxBytes: settings.maxMessageBytes,
    maxTimeoutMs: settings.callSeconds * 1000,
    shutdownSignal: stop,
    contextValues: (request) => createContextValues().set(requestKey, request),
  });
  return (/** @type {import("./site.js").Request} */ request, /** @type {import("./site.js").Response} */ response) => {
    const refused = refusal(request.headers) ?? compressed(request.headers);
    if (refused) {
      answer(response, refused.status, refused.text);
    } else if (request.url === "/health") {
      calls.checkHealth().then(
        () => answer(response, 200, '{"status":"SERVING"}', "application/json"),
        (error) =>
          answer(
            response,
            503,
            JSON.stringify({ status: "NOT_SERVING", message: ConnectError.from(error).rawMessage }),
            "application/json",
          ),
      );
    } else {
      connections.open(request, response);
      connect(request, response);
    }
  };
}

/** Starts the gateway. */
function start(/** @type {Settings} */ settings) {
  const stop = new AbortController();
  const connections = new Connections(settings, log);
  const handle = handler(settings, stop.signal, connections);
  const idle = settings.idleSeconds * 1000;
  const limits = { requestTimeout: settings.callSeconds * 1000, headersTimeout: 20_000 };
  const server = settings.tlsCert
    ? createSecureServer(
        {
          ...limits,
          allowHTTP1: true,
          handshakeTimeout: idle,
          settings: { maxConcurrentStreams: 100 },
          cert: content("tls-cert", settings.tlsCert),
          key: content("tls-key", settings.tlsKey),
        },
        handle,
      )
    : createServer(limits, handle);
  server.on("connection", (socket) => connections.accept(socket));
  server.on("secureConnection", (socket) => socket.on("error", () => socket.destroy()));
  server.setTimeout(idle);
  server.on("timeout", (/** @type {import("./connections.js").Source} */ source) => connections.idle(source));

  const { host, port } = address("listen", settings.listen);
  server.once("error", (error) => {
    log("error", `cannot listen on ${settings.listen}: ${error.message}`);
    process.exitCode = 1;
  });
  server.listen(port, host, () => {
    const bound = /** @type {import("node:net").AddressInfo} */ (server.address());
    const shown = bound.family === "IPv6" ? `[${bound.address}]` : bound.address;
    process.stdout.write(`listening on ${settings.tlsCert ? "https" : "http"}://${shown}:${bound.port}\n`);
    log("info", `serves the page, and passes calls on to lucernad at ${settings.server}`);
  });

  let stopping = false;
  const drain = () => {
    if (stopping) {
      stop.abort(new Error("the gateway is stopping"));
      return;
    }
    stopping = true;
    log("info", `draining for at most ${settings.drainSeconds} s`);
    const late = setTimeout(() => {
      stop.abort(new Error("the gateway is stopping"));
      // The aborted calls send their errors first.
      setTimeout(() => connections.closeAll(), 500).unref();
    }, settings.drainSeconds * 1000);
    server.close(() => {
      clearTimeout(late);
      stop.abort();
      log("info", "ended");
      process.exit(0);
    });
    if ("closeIdleConnections" in server) server.closeIdleConnections();
  };
  for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, drain);
}

const args = process.argv.slice(2);
if (args.includes("--help") || args.includes("-h")) {
  process.stdout.write(help());
} else {
  try {
    start(readSettings(args, process.env));
  } catch (error) {
    if (!(error instanceof SettingError)) throw error;
    process.stderr.write(`lucerna-web: ${error.message}\n`);
    process.exitCode = 2;
  }
}
