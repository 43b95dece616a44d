// The settings of lucerna-web: flags, then the environment, then defaults, as lucernad reads its own.
import { readFileSync } from "node:fs";
import { isIP } from "node:net";

/**
 * @typedef {object} Settings
 * @property {string} listen HOST:PORT for browsers
 * @property {boolean} insecure
 * @property {string} tlsCert
 * @property {string} tlsKey
 * @property {string[]} name further host names under which browsers reach the page
 * @property {string} server HOST:PORT of lucernad
 * @property {boolean} serverTls
 * @property {string} serverCa
 * @property {string} serverCert
 * @property {string} serverKey
 * @property {string} serverName
 * @property {string} tokenFile
 * @property {number} maxMessageBytes
 * @property {number} maxBodyBytes
 * @property {number} maxCalls
 * @property {number} maxConnections
 * @property {number} idleSeconds
 * @property {number} callSeconds
 * @property {number} drainSeconds
 */

/**
 * One setting.  A number is whole and lies in `range`; a switch has no `value`.
 * @typedef {{name: string, value?: string, help: string, default?: string | number, range?: [number, number],
 *   repeats?: boolean}} Setting
 */

/** @type {Setting[]} */
const schema = [
  {
    name: "listen",
    value: "HOST:PORT",
    default: "127.0.0.1:8080",
    help: "Address for browsers; port 0 chooses a free port",
  },
  {
    name: "insecure",
    help: "Allow addresses that other machines can reach, without TLS.  Anyone there can read and send",
  },
  { name: "tls-cert", value: "FILE", help: "Certificate chain for browsers, in PEM" },
  { name: "tls-key", value: "FILE", help: "The private key of --tls-cert, in PEM" },
  {
    name: "name",
    value: "HOST",
    repeats: true,
    help: "Another host name under which browsers reach the page; may be repeated",
  },
  { name: "server", value: "HOST:PORT", default: "127.0.0.1:50051", help: "Address of lucernad" },
  { name: "server-tls", help: "Use TLS to lucernad, with the authorities that Node trusts" },
  { name: "server-ca", value: "FILE", help: "Use TLS to lucernad, with these authorities, in PEM" },
  { name: "server-cert", value: "FILE", help: "The gateway's certificate for lucernad, in PEM" },
  { name: "server-key", value: "FILE", help: "The private key of --server-cert, in PEM" },
  {
    name: "server-name",
    value: "HOST",
    help: "Name that lucernad's certificate must have; default: the host of --server",
  },
  { name: "token-file", value: "FILE", help: "Token for callers that send none.  They then have its rights" },
  {
    name: "max-message-bytes",
    value: "N",
    default: 1 << 26,
    range: [1 << 16, 2147483647],
    help: "Most bytes of one message",
  },
  {
    name: "max-body-bytes",
    value: "N",
    default: 1 << 28,
    range: [1 << 17, 2 ** 40],
    help: "Most bytes of all requests and unread answers; then the connection with most of them is closed",
  },
  { name: "max-calls", value: "N", default: 256, range: [1, 65536], help: "Most calls at once" },
  { name: "max-connections", value: "N", default: 1024, range: [1, 65536], help: "Most open connections of browsers" },
  {
    name: "idle-seconds",
    value: "N",
    default: 60,
    range: [1, 86400],
    help: "Close a connection on which nothing happens for this time, unless a call runs",
  },
  { name: "call-seconds", value: "N", default: 3600, range: [1, 86400], help: "Longest time of one call" },
  {
    name: "drain-seconds",
    value: "N",
    default: 10,
    range: [0, 3600],
    help: "Time that running calls have to finish after SIGTERM",
  },
];

/** The setting's name as a property: "tls-cert" is tlsCert. */
const property = (/** @type {string} */ name) => name.replace(/-(.)/g, (_, letter) => letter.toUpperCase());

/** The environment variable of a setting. */
const variable = (/** @type {string} */ name) => `LUCERNA_WEB_${name.toUpperCase().replaceAll("-", "_")}`;

/** The text of --help. */
export function help() {
  const rows = schema.map(({ name, value, default: fallback, help }) => {
    const flag = `--${name}${value ? ` ${value}` : ""}${fallback === undefined ? "" : `=${fallback}`}`;
    return `  ${flag.padEnd(34)} ${help}`;
  });
  return [
    "lucerna-web: a page in the browser for lucernad, and a gateway from Connect and gRPC-Web to gRPC.",
    "Usage: lucerna-web [OPTIONS]",
    "",
    "Options:",
    `  ${"-h, --help".padEnd(34)} Print this help and exit`,
    ...rows,
    "",
    "Each option may also be set by an environment variable, such as LUCERNA_WEB_LISTEN for --listen.",
    "",
  ].join("\n");
}

/** An error in the settings.  Its text names the setting, its value and what is allowed. */
export class SettingError extends Error {}

/**
 * Splits "HOST:PORT" or "[IPV6]:PORT".
 * @param {"listen" | "server"} setting port 0 is a free port to listen on
 * @param {string} text
 */
export function address(setting, text) {
  const match = /^(?:\[([^\][]+)\]|([^:\][/, ]+)):([^:\]]*)$/.exec(text);
  if (!match || (match[1] && isIP(match[1]) !== 6))
    throw new SettingError(`${setting} = ${text}, allowed: HOST:PORT, such as 127.0.0.1:8080 or [::1]:8080`);
  const port = /^\d+$/.test(match[3]) ? Number(match[3]) : NaN;
  const lowest = setting === "listen" ? 0 : 1;
  if (!(port >= lowest && port <= 65535))
    throw new SettingError(`${setting} = ${text}: port "${match[3]}", allowed: ${lowest} to 65535`);
  return { host: match[1] ?? match[2], port };
}

/** Whether only this machine reaches the host. */
export function isLoopback(/** @type {string} */ host) {
  return host === "localhost" || host === "::1" || (isIP(host) === 4 && host.startsWith("127."));
}

/** The content of a file that a setting names. */
export function content(/** @type {string} */ setting, /** @type {string} */ path) {
  try {
    return readFileSync(path);
  } catch (error) {
    throw new SettingError(`${setting} = ${path}: ${/** @type {Error} */ (error).message}`);
  }
}

/** Reads one value. */
function parsed(
  /** @type {Setting} */ { name, value, range },
  /** @type {string} */ text,
  /** @type {string} */ origin,
) {
  if (value === undefined) {
    if (text === "true" || text === "1") return true;
    if (text === "false" || text === "0") return false;
    throw new SettingError(`${origin} = ${text}, allowed: true or false`);
  }
  if (range) {
    const number = /^\d+$/.test(text) ? Number(text) : NaN;
    if (!(number >= range[0] && number <= range[1]))
      throw new SettingError(`${name} = ${text}, allowed: ${range[0]} to ${range[1]}`);
    return number;
  }
  if (text === "") throw new SettingError(`${name} is empty, allowed: ${value}`);
  return text;
}

/** The values of the flags, as text, by name. */
function flags(/** @type {string[]} */ args) {
  const given = new Map();
  for (let i = 0; i < args.length; ++i) {
    const [, name, inline] = /^--([a-z-]+)(?:=(.*))?$/s.exec(args[i]) ?? [];
    const setting = schema.find((s) => s.name === name);
    if (!setting) throw new SettingError(`${args[i]}: no such option; --help lists them`);
    let text = inline;
    if (text === undefined && setting.value === undefined) text = "true";
    if (text === undefined) text = args[++i];
    if (text === undefined) throw new SettingError(`--${name} needs a value: ${setting.value}`);
    if (given.has(name) && !setting.repeats) throw new SettingError(`--${name} is given twice`);
    given.set(name, [...(given.get(name) ?? []), text]);
  }
  return given;
}

/**
 * Reads and checks all settings.  Throws SettingError.
 * @param {string[]} args the flags
 * @param {NodeJS.ProcessEnv} environment
 * @returns {Settings}
 */
export function readSettings(args, environment) {
  const given = flags(args);
  /** @type {Record<string, any>} */
  const settings = {};
  for (const setting of schema) {
    const { name, value, repeats } = setting;
    const fallback = setting.default ?? (repeats ? [] : value === undefined ? false : "");
    const fromEnvironment = environment[variable(name)];
    /** @type {string[] | undefined} */
    const texts =
      given.get(name) ??
      (fromEnvironment === undefined ? undefined : repeats ? fromEnvironment.split(",") : [fromEnvironment]);
    const values = texts?.map((text) => parsed(setting, text, name));
    settings[property(name)] = values === undefined ? fallback : repeats ? values : values[0];
  }
  check(/** @type {Settings} */ (settings));
  return /** @type {Settings} */ (settings);
}

/** The rules between settings. */
function check(/** @type {Settings} */ s) {
  const pair = (/** @type {string} */ a, /** @type {string} */ b, /** @type {boolean} */ fits) => {
    if (!fits) throw new SettingError(`${a} and ${b}: one is missing, allowed: both or none`);
  };
  pair("tls-cert", "tls-key", Boolean(s.tlsCert) === Boolean(s.tlsKey));
  pair("server-cert", "server-key", Boolean(s.serverCert) === Boolean(s.serverKey));
  const tls = s.serverTls || s.serverCa !== "";
  if ((s.serverCert || s.serverName) && !tls)
    throw new SettingError("server-cert and server-name need TLS to lucernad: server-tls or server-ca");
  if (s.maxBodyBytes < 2 * s.maxMessageBytes)
    throw new SettingError(
      `max-body-bytes = ${s.maxBodyBytes}, allowed: at least 2 times max-message-bytes = ${s.maxMessageBytes}`,
    );
  if (!isLoopback(address("listen", s.listen).host) && !s.tlsCert && !s.insecure)
    throw new SettingError(
      `listen = ${s.listen}, which other machines can reach; allowed: a loopback address, or tls-cert and tls-key, ` +
        "or the option insecure",
    );
  // Tokens of callers travel on this connection.
  if (!isLoopback(address("server", s.server).host) && !tls && !s.insecure)
    throw new SettingError(
      `server = ${s.server}, on another machine and without TLS; allowed: a loopback address, or server-tls or ` +
        "server-ca, or the option insecure",
    );
}
