// The calls of lucernad, through the gateway that served the page.
import { Code, ConnectError, createClient } from "@connectrpc/connect";
import { createConnectTransport } from "@connectrpc/connect-web";

// The build generates these beside the sources.
import { AdminService } from "../../generated/lucerna/v1/admin_pb.js";
import { LightingService } from "../../generated/lucerna/v1/lighting_pb.js";
import { RenderService } from "../../generated/lucerna/v1/render_pb.js";
import { SceneService } from "../../generated/lucerna/v1/scene_pb.js";

// In memory only, so that it does not outlive the page.
let token = "";

/** Sends this token with each call from now on. */
export function useToken(/** @type {string} */ text) {
  token = text.trim();
}

const transport = createConnectTransport({
  baseUrl: location.origin,
  useBinaryFormat: true,
  interceptors: [
    (next) => (request) => {
      if (token) request.header.set("authorization", `Bearer ${token}`);
      return next(request);
    },
  ],
});

export const scenes = createClient(SceneService, transport);
export const lighting = createClient(LightingService, transport);
export const renders = createClient(RenderService, transport);
export const admin = createClient(AdminService, transport);

/** What an error means for the page. */
export function kindOf(/** @type {unknown} */ reason) {
  const { code, cause } = ConnectError.from(reason);
  // The browser reports a gateway that it cannot reach as a TypeError.
  if (cause instanceof TypeError || code === Code.Unavailable) return "lost";
  if (code === Code.Canceled) return "cancelled";
  if (code === Code.Unauthenticated) return "token";
  if (code === Code.PermissionDenied) return "denied";
  if (code === Code.NotFound) return "missing";
  return "other";
}

/** An error for people. */
export function textOf(/** @type {unknown} */ reason) {
  const error = ConnectError.from(reason);
  if (error.cause instanceof TypeError) return "The gateway of this page does not answer.";
  // A sentence, unless it begins with a name, such as "room.pbrt:3:1: what".
  const text = error.rawMessage.replace(/^[a-z]+(?= )/, (word) => word.charAt(0).toUpperCase() + word.slice(1));
  return text + (/[.!?]$/.test(text) ? "" : ".");
}
