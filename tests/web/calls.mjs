// Requests to the gateway.
import { request as httpRequest } from "node:http";
import { request as httpsRequest } from "node:https";

/** Sends a request with any headers.  The answer has its body as text. */
export function send(address, { path = "/", method = "GET", headers = {}, body, ca } = {}) {
  const { hostname, port, protocol } = new URL(address);
  return new Promise((resolve, reject) => {
    const make = protocol === "https:" ? httpsRequest : httpRequest;
    const sent = make(
      { host: hostname, port, path, method, headers, ca, servername: "localhost", agent: false },
      (answer) => {
        let text = "";
        answer.setEncoding("utf8");
        answer.on("data", (part) => (text += part));
        answer.on("end", () => resolve({ status: answer.statusCode, headers: answer.headers, text }));
      },
    );
    sent.on("error", reject);
    sent.end(body);
  });
}

/** Calls a method by the Connect protocol with JSON. */
export function call(address, method, message = {}, { headers = {}, ca } = {}) {
  return send(address, {
    path: `/lucerna.v1.${method}`,
    method: "POST",
    headers: { "Content-Type": "application/json", ...headers },
    body: typeof message === "string" || Buffer.isBuffer(message) ? message : JSON.stringify(message),
    ca,
  });
}
