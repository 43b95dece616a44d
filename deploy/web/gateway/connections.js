// The connections of browsers: how many there are, and how many bytes they hold.

/**
 * @typedef {import("./settings.js").Settings} Settings
 * @typedef {import("./site.js").Request} Request
 * @typedef {import("./site.js").Response} Response
 * @typedef {import("node:net").Socket} Socket
 * @typedef {Socket | import("node:http2").ServerHttp2Session} Source
 *
 * A request and its answer.  `waits`: for bytes of the browser, or for the browser to read; otherwise for lucernad.
 * `upload`: it is a stream of requests, and so a call from its first byte on.  `seen`: when it last showed life.
 * @typedef {{waits: boolean, bytes: number, upload: boolean, seen: number}} Exchange
 * @typedef {{key: string, socket: Socket, exchanges: Set<Exchange>}} Connection
 */

/** The same for a socket, and for the secured or shared one that Node makes of it. */
const peer = (/** @type {Socket} */ socket) => `${socket.remoteAddress} ${socket.remotePort}`;

/** Whether no call of the connection runs. */
const waits = (/** @type {Connection} */ connection) => [...connection.exchanges].every((exchange) => exchange.waits);

/** The bytes of a connection that wait for its browser. */
const unfinished = (/** @type {Connection} */ { exchanges }) =>
  [...exchanges].reduce((sum, exchange) => sum + (exchange.waits ? exchange.bytes : 0), 0);

export class Connections {
  /** @type {Map<string, Connection>} by peer; first those that showed no life for longest */
  #all = new Map();
  /** @type {WeakMap<Request, {begun: () => void, taken: () => void}>} */
  #uploads = new WeakMap();
  #bytes = 0;
  #logged = 0;
  #settings;
  #log;

  constructor(/** @type {Settings} */ settings, /** @type {(level: string, text: string) => void} */ log) {
    this.#settings = settings;
    this.#log = log;
  }

  /** Takes a new connection.  If all places are taken, the one that waits for longest goes; or this one if all work. */
  accept(/** @type {Socket} */ socket) {
    socket.on("error", () => socket.destroy());
    if (this.#all.size >= this.#settings.maxConnections) {
      const silent = [...this.#all.values()].find(waits);
      if (!silent) {
        socket.destroy();
        return;
      }
      this.#end(silent, "was silent for longest, and another one came");
    }
    const connection = { key: peer(socket), socket, exchanges: new Set() };
    this.#all.set(connection.key, connection);
    socket.once("close", () => this.#forget(connection));
  }

  /** Counts the bytes of a request and of its answer until the answer is sent. */
  open(/** @type {Request} */ request, /** @type {Response} */ response) {
    const connection = this.#all.get(peer(request.socket));
    if (!connection) {
      request.destroy();
      return;
    }
    /** @type {Exchange} */
    const exchange = { waits: true, bytes: 0, upload: false, seen: Date.now() };
    const now = (/** @type {boolean} */ waiting, /** @type {number} */ bytes) => {
      if (!connection.exchanges.has(exchange)) return;
      // The connection shows life: it becomes the last one.
      this.#all.delete(connection.key);
      this.#all.set(connection.key, connection);
      this.#bytes += bytes - exchange.bytes;
      exchange.seen = Date.now();
      exchange.waits = waiting;
      exchange.bytes = bytes;
      if (this.#bytes > this.#settings.maxBodyBytes) this.#relieve();
    };
    connection.exchanges.add(exchange);
    now(true, 0);
    response.once("close", () => {
      now(true, 0);
      connection.exchanges.delete(exchange);
    });

    this.#uploads.set(request, {
      begun: () => (exchange.upload = true),
      taken: () => now(exchange.waits, 0),
    });
    const body = request[Symbol.asyncIterator].bind(request);
    request[Symbol.asyncIterator] = async function* () {
      for await (const chunk of body()) {
        now(true, exchange.bytes + chunk.length);
        yield chunk;
      }
      now(false, exchange.bytes);
    };
    const write = /** @type {(...given: any[]) => boolean} */ (response.write.bind(response));
    response.write = (/** @type {any[]} */ ...[chunk, encoding, done]) => {
      now(true, chunk.length);
      return write(chunk, encoding, (/** @type {any} */ error) => {
        now(false, 0);
        done?.(error);
      });
    };
  }

  /** `begun`: a stream of requests is a call now.  `taken`: a message was passed on, and its bytes are not held. */
  upload(/** @type {Request} */ request) {
    return this.#uploads.get(request);
  }

  /** Ends the upload that was silent for longest, and for a second.  False if there is none. */
  endSilentUpload() {
    const silent = (/** @type {Exchange} */ { upload, waits, seen }) => upload && waits && Date.now() - seen >= 1000;
    const connection = [...this.#all.values()].find(({ exchanges }) => [...exchanges].some(silent));
    if (connection) this.#end(connection, "had a silent upload, and another call came");
    return connection !== undefined;
  }

  /** Closes a connection on which nothing happened for a while, unless a call runs. */
  idle(/** @type {Source} */ source) {
    const socket = "socket" in source ? source.socket : source;
    const connection = this.#all.get(peer(/** @type {Socket} */ (socket)));
    if (connection && waits(connection)) connection.socket.destroy();
  }

  closeAll() {
    for (const { socket } of this.#all.values()) socket.destroy();
  }

  /** Too many bytes are held: ends the connection with the most that wait for its browser. */
  #relieve() {
    const most = [...this.#all.values()].reduce((a, b) => (unfinished(b) > unfinished(a) ? b : a));
    this.#end(most, `held ${unfinished(most)} bytes, of at most ${this.#settings.maxBodyBytes} of all`);
  }

  #end(/** @type {Connection} */ connection, /** @type {string} */ reason) {
    // An attack must not fill the log: at most a line in a second.
    if (Date.now() - this.#logged >= 1000) {
      this.#logged = Date.now();
      this.#log("warning", `closed a connection of ${connection.socket.remoteAddress}: it ${reason}`);
    }
    this.#forget(connection);
    connection.socket.destroy();
  }

  #forget(/** @type {Connection} */ connection) {
    if (this.#all.get(connection.key) === connection) this.#all.delete(connection.key);
    for (const exchange of connection.exchanges) this.#bytes -= exchange.bytes;
    connection.exchanges.clear();
  }
}
