// A dial of accuracy: steps, and the time that each of them took.
import { make } from "./dom.js";
import { duration } from "./format.js";

export class Dial {
  /** @type {number[]} */ #steps;
  /** Seconds of each step, as measured last; NaN: not yet. */
  /** @type {number[]} */ #seconds;
  #text;
  #prefix;
  #slider;
  #value;
  #bars;

  /**
   * @param {HTMLElement} box
   * @param {object} dial
   * @param {string} dial.name
   * @param {number[]} dial.steps from coarse to fine
   * @param {number} dial.start one of them
   * @param {(step: number) => string} dial.text
   * @param {string} dial.prefix of the value chosen
   * @param {() => void} dial.changed
   */
  constructor(box, { name, steps, start, text, prefix, changed }) {
    this.#steps = steps;
    this.#text = text;
    this.#prefix = prefix;
    this.#seconds = steps.map(() => NaN);
    const id = `${box.id}-slider`;
    this.#value = make("output", { for: id });
    this.#slider = make("input", {
      id,
      type: "range",
      min: 0,
      max: steps.length - 1,
      step: 1,
      value: steps.indexOf(start),
    });
    this.#bars = make("ol", { class: "times", "aria-label": "Time of each step" });
    this.#slider.addEventListener("input", () => this.#show());
    this.#slider.addEventListener("change", changed);
    box.append(
      make("div", { class: "dial-head" }, make("label", { for: id, text: name }), this.#value),
      this.#slider,
      this.#bars,
    );
    this.#show();
  }

  get value() {
    return this.#steps[Number(this.#slider.value)];
  }

  /** Chooses the step nearest to a value. */
  set value(wanted) {
    const distance = (/** @type {number} */ step) => Math.abs(Math.log(step / wanted));
    const nearest = this.#steps.reduce((best, step) => (distance(step) < distance(best) ? step : best));
    this.#slider.value = String(this.#steps.indexOf(nearest));
    this.#show();
  }

  /** Keeps the time that a step took [s]. */
  measured(/** @type {number} */ step, /** @type {number} */ seconds) {
    this.#seconds[this.#steps.indexOf(step)] = seconds;
    this.#show();
  }

  /** Forgets all times: they belong to another scene. */
  forget() {
    this.#seconds.fill(NaN);
    this.#show();
  }

  #show() {
    const at = Number(this.#slider.value),
      longest = Math.max(...this.#seconds.filter((s) => s > 0), 1e-9);
    const chosen = `${this.#prefix}${this.#text(this.#steps[at])}`;
    this.#value.textContent = chosen;
    this.#slider.setAttribute("aria-valuetext", chosen);
    this.#slider.style.setProperty("--part", `${(100 * at) / (this.#steps.length - 1)}%`);
    this.#bars.replaceChildren(
      ...this.#steps.map((step, i) => {
        const seconds = this.#seconds[i];
        const bar = make("span", { class: "time-bar", "aria-hidden": "true" });
        // Times span decades, so equal steps of height are equal factors.
        bar.style.height = seconds > 0 ? `${Math.max(8, 100 + 20 * Math.log2(seconds / longest))}%` : "0";
        const label = seconds > 0 ? duration(seconds) : "–";
        return make(
          "li",
          { class: i === at ? "now" : "" },
          make("span", { class: "time-space", "aria-hidden": "true" }, bar),
          make("span", { class: "time-step", text: this.#text(step) }),
          make("span", { class: "time-value", text: label }),
        );
      }),
    );
  }
}
