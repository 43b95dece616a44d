// Passes every call of lucerna.v1 on to lucernad.
import { Code, ConnectError, createClient, createContextKey } from "@connectrpc/connect";
import { createGrpcTransport } from "@connectrpc/connect-node";

// The build generates these beside the sources.
import { Health } from "../../generated/grpc/health/v1/health_pb.js";
import { AdminService } from "../../generated/lucerna/v1/admin_pb.js";
import { LightingService } from "../../generated/lucerna/v1/lighting_pb.js";
import { RenderService } from "../../generated/lucerna/v1/render_pb.js";
import { SceneService } from "../../generated/lucerna/v1/scene_pb.js";
import { content } from "./settings.js";

/** @typedef {import("./settings.js").Settings} Settings */
/** @typedef {import("@connectrpc/connect").HandlerContext} Context */

/** The request of a call. */
export const requestKey = createContextKey(/** @type {any} */ (undefined));

/**
 * The connection to lucernad.
 * @param {Settings} s
 */
export function connection(s) {
  const tls = s.serverTls || s.serverCa !== "";
  const file = (/** @type {string} */ setting, /** @type {string} */ path) =>
    path ? content(setting, path) : undefined;
  return createGrpcTransport({
    baseUrl: `${tls ? "https" : "http"}://${s.server}`,
    readMaxBytes: s.maxMessageBytes,
    writeMaxBytes: s.maxMessageBytes,
    // Finds a server whose machine is gone.  lucernad allows a ping every 5 s.
    pingIntervalMs: 30_000,
    nodeOptions: tls
      ? {
          ca: file("server-ca", s.serverCa),
          cert: file("server-cert", s.serverCert),
          key: file("server-key", s.serverKey),
          ...(s.serverName ? { servername: s.serverName } : {}),
        }
      : {},
  });
}

/** The token of a file, without the line's end. */
export function tokenOf(/** @type {string} */ path) {
  return path ? content("token-file", path).toString("utf8").trim() : "";
}

/**
 * An error of lucernad as it was sent, without the headers of its connection.
 * @param {unknown} reason
 * @param {string} server
 * @param {boolean} ended whether the caller or the gateway ended the call
 */
function passedOn(reason, server, ended) {
  const error = ConnectError.from(reason);
  // A code of Node instead of gRPC: it could not reach the server, or lost it.  A server that closes the connection,
  // for example because it wants a certificate, looks as if the call had been cancelled.
  const code = /** @type {NodeJS.ErrnoException | undefined} */ (error.cause)?.code;
  if (!ended && (code !== undefined || error.code === Code.Canceled))
    return new ConnectError(`lucernad does not answer at ${server}: ${code ?? error.rawMessage}`, Code.Unavailable);
  const passed = new ConnectError(error.rawMessage, error.code);
  passed.details = error.details;
  return passed;
}

/**
 * The calls of all services, and the health of lucernad.
 * @param {Settings} settings
 * @param {AbortSignal} stop ends all calls
 * @param {import("./connections.js").Connections} connections
 */
export function proxy(settings, stop, connections) {
  const transport = connection(settings);
  const token = tokenOf(settings.tokenFile);
  const health = createClient(Health, transport);
  let running = 0;

  const options = (/** @type {Context} */ context) => {
    const given = context.requestHeader.get("authorization") ?? (token ? `Bearer ${token}` : null);
    return {
      signal: AbortSignal.any([context.signal, stop]),
      timeoutMs: Math.min(context.timeoutMs() ?? Infinity, settings.callSeconds * 1000),
      headers: given === null ? {} : { authorization: given },
    };
  };

  /** Counts a call, so that no more than allowed run at once. */
  const begin = () => {
    if (running >= settings.maxCalls && !connections.endSilentUpload())
      throw new ConnectError(`calls at once = ${running + 1}, allowed: ${settings.maxCalls}`, Code.ResourceExhausted);
    running += 1;
  };

  /** The function that answers one method. */
  const forward = (/** @type {import("@bufbuild/protobuf").DescMethod} */ method, /** @type {any} */ client) => {
    const call = client[method.localName];
    if (method.methodKind === "server_streaming")
      return async function* (/** @type {any} */ request, /** @type {Context} */ context) {
        begin();
        try {
          yield* call(request, options(context));
        } catch (error) {
          throw passedOn(error, settings.server, context.signal.aborted || stop.aborted);
        } finally {
          running -= 1;
        }
      };
    const passing = async function* (/** @type {any} */ requests, /** @type {Context} */ context) {
      const upload = connections.upload(context.values.get(requestKey));
      upload?.begun();
      for await (const request of requests) {
        upload?.taken();
        yield request;
      }
    };
    return async (/** @type {any} */ request, /** @type {Context} */ context) => {
      begin();
      try {
        return await call(method.methodKind === "unary" ? request : passing(request, context), options(context));
      } catch (error) {
        throw passedOn(error, settings.server, context.signal.aborted || stop.aborted);
      } finally {
        running -= 1;
      }
    };
  };

  return {
    /** @param {import("@connectrpc/connect").ConnectRouter} router */
    routes(router) {
      for (const service of [SceneService, LightingService, RenderService, AdminService]) {
        const client = createClient(service, transport);
        router.service(
          service,
          Object.fromEntries(service.methods.map((method) => [method.localName, forward(method, client)])),
        );
      }
    },
    /** Throws if lucernad does not serve. */
    async checkHealth() {
      let status;
      try {
        ({ status } = await health.check({}, { timeoutMs: 5000, signal: stop }));
      } catch (error) {
        throw passedOn(error, settings.server, stop.aborted);
      }
      if (status !== 1) throw new ConnectError("lucernad is starting or shutting down", Code.Unavailable);
    },
  };
}
