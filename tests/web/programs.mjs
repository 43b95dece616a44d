// Programs for tests of the page: lucernad, the gateway, and a browser, all on the loopback interface.
import { execFile, spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../..", import.meta.url));
const bin = `${root}build/release/bin/`;

/** Loads npm packages that deploy/web/build.sh has installed. */
export const require = createRequire(`${root}build/web/`);

/** Runs a program for at most five minutes.  Never throws: `status` is null if it was stopped. */
export function run(program, ...given) {
  return new Promise((resolve) => {
    const limits = { timeout: 300_000, killSignal: "SIGKILL", maxBuffer: 1 << 26 };
    execFile(program, given, limits, (error, stdout, stderr) => {
      resolve({ status: error ? (error.code ?? null) : 0, stdout, stderr });
    });
  });
}

/** Waits until a condition holds.  The time limit of the test ends a wait without end. */
export async function until(holds) {
  while (!(await holds())) await sleep(50);
}

const running = new Set();

/** Stops what the tests started and did not stop, because they failed. */
export const stopAll = () => Promise.all([...running].map((program) => program.stop("SIGKILL")));

/** A program that listens, and says so in its first line. */
export class Program {
  #process;
  #kill = () => this.#process.kill("SIGKILL");
  /** What it wrote. */
  output = "";

  static async start(command, args, environment = {}) {
    const program = new Program();
    running.add(program);
    program.#process = spawn(command, args, {
      stdio: ["ignore", "pipe", "pipe"],
      env: { ...process.env, ...environment },
    });
    program.ended = new Promise((resolve) => program.#process.once("exit", (status) => resolve(status)));
    // It must not outlive a test that is stopped.
    process.once("exit", program.#kill);
    for (const stream of ["stdout", "stderr"]) program.#process[stream].on("data", (text) => (program.output += text));
    program.address = await new Promise((resolve, reject) => {
      const late = setTimeout(() => reject(new Error(`${command} does not listen: ${program.output}`)), 280_000);
      program.#process.stdout.on("data", () => {
        const found = /listening on (\S+)/.exec(program.output)?.[1];
        if (!found) return;
        clearTimeout(late);
        resolve(found);
      });
      program.ended.then((status) => {
        clearTimeout(late);
        reject(new Error(`${command} ended with status ${status}: ${program.output}`));
      });
    });
    return program;
  }

  /** Ends it, and waits for its end.  Returns its status. */
  async stop(signal = "SIGTERM") {
    process.off("exit", this.#kill);
    if (this.#process.exitCode === null && this.#process.signalCode === null) this.#process.kill(signal);
    // Only ends programs that hang: a slow machine may need a minute for a call that runs.
    const late = setTimeout(this.#kill, 280_000);
    const status = await this.ended;
    running.delete(this);
    clearTimeout(late);
    return status;
  }
}

/** A server with the shipped scenes, or those of another folder. */
export const startServer = ({ listen = "127.0.0.1:0", scenes = `${root}scenes`, options = [] } = {}) =>
  Program.start(`${bin}lucernad`, [`--listen=${listen}`, `--scene-root=${scenes}`, ...options]);

/** A gateway to the server at `server`. */
export const startGateway = (server, ...options) =>
  Program.start(process.execPath, [
    `${root}build/web/lucerna-web.mjs`,
    "--listen=127.0.0.1:0",
    `--server=${server}`,
    ...options,
  ]);

/** Runs `lucerna` against the server.  Throws if it fails. */
export async function lucerna(server, ...given) {
  const { status, stdout, stderr } = await run(`${bin}lucerna`, `--server=${server}`, ...given);
  if (status !== 0) throw new Error(`lucerna ${given.join(" ")}: ${stderr}${stdout}`);
  return stdout;
}

/** Makes an authority in `folder`, and certificates that it signs. */
export async function certificates(folder) {
  const openssl = async (...given) => {
    const { status, stderr } = await run("openssl", ...given);
    if (status !== 0) throw new Error(`openssl ${given.join(" ")}: ${stderr}`);
  };
  const ec = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"];
  const path = (name) => `${folder}/${name}`;
  for (const name of ["authority", "stranger"])
    await openssl(
      "req",
      "-x509",
      ...ec,
      "-days",
      "2",
      "-subj",
      `/CN=${name}`,
      "-keyout",
      path(`${name}.key`),
      "-out",
      path(`${name}.pem`),
    );
  writeFileSync(path("names"), "subjectAltName=DNS:localhost,IP:127.0.0.1\n");
  for (const name of ["server", "gateway"]) {
    await openssl(
      "req",
      "-new",
      ...ec,
      "-subj",
      `/CN=${name}`,
      "-keyout",
      path(`${name}.key`),
      "-out",
      path(`${name}.csr`),
    );
    await openssl(
      "x509",
      "-req",
      "-in",
      path(`${name}.csr`),
      "-CA",
      path("authority.pem"),
      "-CAkey",
      path("authority.key"),
      "-CAcreateserial",
      "-days",
      "2",
      "-extfile",
      path("names"),
      "-out",
      path(`${name}.pem`),
    );
  }
  return path;
}

/** Debian's Chromium, without a window and with a profile of its own. */
export async function startBrowser() {
  const puppeteer = require("puppeteer-core");
  const profile = mkdtempSync(`${tmpdir()}/lucerna-web.`);
  const browser = await puppeteer.launch({
    executablePath: "/usr/bin/chromium",
    userDataDir: profile,
    // As root, Chromium has no sandbox of its own.  The machine of a test may have a small /dev/shm and no GPU.
    args: ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--force-device-scale-factor=1"],
    timeout: 120_000,
    protocolTimeout: 300_000,
  });
  return {
    browser,
    async close() {
      await browser.close();
      rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
    },
  };
}
