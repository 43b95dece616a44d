// Lucerna's programs, for tests: a server on a free port of the loopback interface, and the client.
import { execFile, spawn } from "node:child_process";
import { closeSync, mkdtempSync, openSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../..", import.meta.url));
const bin = `${root}build/release/bin/`;

/** Loads npm packages that .ci/install-tools.sh has installed. */
export const require = createRequire(`${root}build/tools/`);

/** Runs a program for at most five minutes.  Never throws: `status` is null if it was stopped. */
export function run(program, ...given) {
  return new Promise((resolve) => {
    const limits = { timeout: 300_000, killSignal: "SIGKILL", maxBuffer: 1 << 26 };
    execFile(program, given, limits, (error, stdout, stderr) => {
      resolve({ status: error ? (error.code ?? null) : 0, stdout, stderr });
    });
  });
}

/** A running lucernad with a temporary folder, which both end with `stop`. */
export class Server {
  #process;
  #address;
  #kill = () => this.#process.kill("SIGKILL");

  /** Scenes come from `sceneRoot`, by default from the temporary folder. */
  static async start(sceneRoot) {
    const server = new Server();
    server.folder = mkdtempSync(`${tmpdir()}/lucerna-gltf.`);
    const log = `${server.folder}/lucernad.log`;
    const file = openSync(log, "w");
    const options = ["--listen=127.0.0.1:0", `--scene-root=${sceneRoot ?? server.folder}`];
    server.#process = spawn(`${bin}lucernad`, options, { stdio: ["ignore", file, file] });
    closeSync(file);
    // The server must not outlive a test that is stopped.
    process.once("exit", server.#kill);
    for (const signal of ["SIGINT", "SIGTERM"]) process.once(signal, () => process.exit(1));
    for (let waited = 0; !server.#address; waited += 50) {
      await sleep(50);
      server.#address = /listens on (127\.0\.0\.1:\d+)/.exec(readFileSync(log, "utf8"))?.[1];
      if (!server.#address && (waited > 280_000 || server.#process.exitCode !== null)) {
        const text = readFileSync(log, "utf8");
        await server.stop();
        throw new Error(`lucernad does not listen: ${text}`);
      }
    }
    return server;
  }

  /** Runs `lucerna` with the given command and options. */
  lucerna(...given) {
    return run(`${bin}lucerna`, `--server=${this.#address}`, ...given);
  }

  /** The answer of `lucerna`, as an object.  Throws if it fails. */
  async answer(...given) {
    const { status, stdout, stderr } = await this.lucerna("--json", ...given);
    if (status !== 0) throw new Error(`lucerna ${given.join(" ")}: ${stderr}${stdout}`);
    return JSON.parse(stdout);
  }

  async stop() {
    if (this.#process.exitCode === null && this.#process.signalCode === null) {
      const ended = new Promise((resolve) => this.#process.once("exit", resolve));
      this.#process.kill("SIGTERM");
      const late = setTimeout(this.#kill, 280_000);
      await ended;
      clearTimeout(late);
    }
    process.off("exit", this.#kill);
    rmSync(this.folder, { recursive: true });
  }
}
