// Serves the files of the page from memory.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { extname, join } from "node:path";

/** @type {Record<string, string>} */
const types = {
  ".css": "text/css; charset=utf-8",
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".svg": "image/svg+xml",
};

/** Of every answer that is not a call.  The page loads nothing from other hosts and runs no inline script. */
export const headers = {
  "Content-Security-Policy":
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; base-uri 'none'; " +
    "form-action 'none'; frame-ancestors 'none'",
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
  "Referrer-Policy": "no-referrer",
  "X-Content-Type-Options": "nosniff",
};

/**
 * @typedef {ReturnType<typeof import("@connectrpc/connect-node").connectNodeAdapter>} Handler
 * @typedef {Parameters<Handler>[0]} Request
 * @typedef {Parameters<Handler>[1]} Response
 */

/**
 * Answers with a short text.
 * @param {Response} response
 * @param {number} status
 * @param {string} text
 */
export function answer(response, status, text, type = "text/plain; charset=utf-8") {
  response.writeHead(status, { ...headers, "Cache-Control": "no-store", "Content-Type": type });
  response.end(`${text}\n`);
}

/**
 * The handler of all paths that are no calls.
 * @param {string} folder the files of the page
 */
export function site(folder) {
  const files = new Map(
    readdirSync(folder).map((name) => {
      const bytes = readFileSync(join(folder, name));
      const tag = `"${createHash("sha256").update(bytes).digest("hex").slice(0, 32)}"`;
      return [`/${name}`, { bytes, tag, type: types[extname(name)] ?? "application/octet-stream" }];
    }),
  );
  return (/** @type {Request} */ request, /** @type {Response} */ response) => {
    const path = (request.url ?? "/").split("?")[0];
    const file = files.get(path === "/" ? "/index.html" : path);
    if (!file) {
      answer(response, 404, "no such file and no such call");
      return;
    }
    if (request.method !== "GET" && request.method !== "HEAD") {
      answer(response, 405, `method = ${request.method}, allowed: GET, HEAD`);
      return;
    }
    // The browser asks each time, so that a new version of the page replaces the old one.
    const common = { ...headers, "Cache-Control": "no-cache", ETag: file.tag };
    if (request.headers["if-none-match"] === file.tag) {
      response.writeHead(304, common);
      response.end();
      return;
    }
    response.writeHead(200, { ...common, "Content-Type": file.type, "Content-Length": file.bytes.length });
    response.end(request.method === "HEAD" ? "" : file.bytes);
  };
}
