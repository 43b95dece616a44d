// Work that newer work of the same kind replaces.
import { kindOf, textOf } from "./api.js";
import { handled } from "./session.js";

/** Work of one kind: a new one ends the one before. */
export class Latest {
  #missing;

  /** @param {() => Promise<boolean>} missing is called if the server does not have the scene; true: it is open again */
  constructor(missing) {
    this.#missing = missing;
  }

  #controller = new AbortController();
  /** Runs the work, and shows its errors in `box`. */
  async run(/** @type {(signal: AbortSignal) => Promise<void>} */ work, /** @type {HTMLElement} */ box) {
    this.#controller.abort();
    const controller = (this.#controller = new AbortController());
    try {
      box.textContent = "";
      await work(controller.signal);
    } catch (error) {
      if (controller.signal.aborted || handled(error)) return;
      // The server has released the scene, or was started again.
      if (kindOf(error) === "missing" && (await this.#missing())) return;
      box.textContent = textOf(error);
    }
  }
  end() {
    this.#controller.abort();
  }
}
