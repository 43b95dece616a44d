// Refuses requests that other pages make a browser send.
import { isLoopback } from "./settings.js";

/**
 * The host of a Host header or of an origin, without the port, in lower case; undefined if it is malformed.
 * @param {string | undefined} authority
 */
function hostOf(authority) {
  if (!authority || /[\s/@?#\\]/.test(authority)) return undefined;
  try {
    return new URL(`http://${authority}`).hostname.replace(/^\[|\]$/g, "").toLowerCase();
  } catch {
    return undefined;
  }
}

/**
 * Makes the check of one gateway.  It returns the reason to refuse a request, or undefined.
 *
 * A page of another site may make its host name point to this machine (DNS rebinding).  For the browser its requests
 * are then of the same origin, but they have that name in Host.
 * @param {string[]} names the hosts under which browsers may reach the gateway
 */
export function guard(names) {
  const allowed = new Set(names.map((name) => name.toLowerCase()));
  if ([...allowed].some(isLoopback)) for (const name of ["localhost", "127.0.0.1", "::1"]) allowed.add(name);
  /** @param {import("node:http").IncomingHttpHeaders & {":authority"?: string}} headers */
  return (headers) => {
    const authority = headers[":authority"] ?? headers.host;
    const host = hostOf(authority);
    if (host === undefined || !allowed.has(host))
      return {
        status: 421,
        text: `Host = ${authority ?? "unset"}, allowed: ${[...allowed].join(", ")}; --name adds a name`,
      };
    const { origin } = headers;
    if (origin !== undefined && origin.replace(/^https?:\/\//, "") !== authority)
      return { status: 403, text: `Origin = ${origin}, allowed: the origin of this page` };
    const site = headers["sec-fetch-site"];
    // Links of other sites may open the page.  Its files and calls are only for itself.
    if (site === "cross-site" && headers["sec-fetch-mode"] !== "navigate")
      return { status: 403, text: "Sec-Fetch-Site = cross-site, allowed: requests of this page" };
    return undefined;
  };
}

/** The reason to refuse a compressed request, whose size is not known before it is unpacked; or undefined. */
export function compressed(/** @type {import("node:http").IncomingHttpHeaders} */ headers) {
  for (const name of ["content-encoding", "connect-content-encoding", "grpc-encoding"])
    if ((headers[name] ?? "identity") !== "identity")
      return { status: 415, text: `${name} = ${headers[name]}, allowed: identity` };
  return undefined;
}
