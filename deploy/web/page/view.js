// Draws the picture and the marks over it, and reads the mouse and the keys.
import { colour, linearScale, logScale } from "./colours.js";
import { byId } from "./dom.js";

/** @typedef {{x: number, y: number}} Pixel */
/** @typedef {import("./picture.js").Picture} Picture */

const canvas = /** @type {HTMLCanvasElement} */ (byId("canvas"));
const marks = /** @type {HTMLCanvasElement} */ (byId("marks"));
const frame = byId("picture");

/** The transfer function of sRGB, for shares of 0 to 1. */
const encoded = Uint8ClampedArray.from({ length: 4097 }, (_, i) => {
  const v = i / 4096;
  return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055) + 0.5;
});

/** Bright parts lose contrast instead of detail: straight up to 0.6, then towards 1. */
const shoulder = (/** @type {number} */ v) => (v <= 0.6 ? v : 0.6 + 0.4 * (1 - Math.exp(-(v - 0.6) / 0.4)));

/**
 * Paints the picture into its canvas.
 * @param {Picture} picture
 * @param {"photo" | "luminance" | "error"} view
 * @param {number} exposure [EV]
 * @returns {import("./colours.js").Scale | undefined} of the false colours
 */
export function paint(picture, view, exposure) {
  const { width, height, rgb, luminance, error } = picture;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const image = context.createImageData(width, height);
  const pixels = image.data;
  let scale;
  if (view === "photo") {
    // The brightest twentieth becomes nearly white.
    const gain = (0.85 * 2 ** exposure) / (picture.quantile(0.95) || 1);
    for (let i = 0, p = 0; i < rgb.length; ++p)
      for (let c = 0; c < 3; ++c, ++i)
        pixels[4 * p + c] = encoded[Math.round(4096 * Math.min(1, shoulder(Math.max(0, rgb[i] * gain))))];
  } else {
    const values = view === "luminance" ? luminance : error;
    scale =
      view === "luminance"
        ? logScale(picture.quantile(0.01), picture.quantile(0.999))
        : linearScale(0, 2 * picture.medianError());
    for (let p = 0; p < values.length; ++p) {
      const [r, g, b] = values[p] > 0 ? colour(scale.share(values[p])) : [0, 0, 0];
      pixels[4 * p] = r;
      pixels[4 * p + 1] = g;
      pixels[4 * p + 2] = b;
    }
  }
  for (let p = 3; p < pixels.length; p += 4) pixels[p] = 255;
  context.putImageData(image, 0, 0);
  return scale;
}

/**
 * What is marked over the picture, in pixels of the picture.
 * @typedef {object} Marks
 * @property {Pixel} [cursor] the cross-hair
 * @property {Pixel[]} pins measured or chosen places
 * @property {{from: Pixel, to: Pixel}} [line]
 * @property {ImageBitmap | HTMLCanvasElement} [overlay] false colours over the whole picture
 */

/** Draws the marks. */
export function drawMarks(
  /** @type {Marks} */ { cursor, pins, line, overlay },
  /** @type {number} */ width,
  /** @type {number} */ height,
) {
  const box = canvas.getBoundingClientRect();
  const sharp = window.devicePixelRatio || 1;
  Object.assign(marks, { width: Math.round(box.width * sharp), height: Math.round(box.height * sharp) });
  const context = /** @type {CanvasRenderingContext2D} */ (marks.getContext("2d"));
  const fx = marks.width / width,
    fy = marks.height / height;
  if (overlay) {
    context.imageSmoothingEnabled = true;
    context.drawImage(overlay, 0, 0, marks.width, marks.height);
  }
  /** Strokes twice, dark and light, so that the mark shows on every picture. */
  const stroke = (/** @type {() => void} */ path) => {
    for (const [style, size] of /** @type {[string, number][]} */ ([
      ["rgb(0 0 0 / 75%)", 3.5],
      ["#fff", 1.5],
    ])) {
      context.strokeStyle = style;
      context.lineWidth = size * sharp;
      context.beginPath();
      path();
      context.stroke();
    }
  };
  const centre = (/** @type {Pixel} */ p) => [(p.x + 0.5) * fx, (p.y + 0.5) * fy];
  if (line)
    stroke(() => {
      const [a, b] = centre(line.from),
        [c, d] = centre(line.to);
      context.moveTo(a, b);
      context.lineTo(c, d);
    });
  for (const pin of pins)
    stroke(() => {
      const [x, y] = centre(pin);
      context.arc(x, y, 5 * sharp, 0, 2 * Math.PI);
    });
  if (cursor)
    stroke(() => {
      const [x, y] = centre(cursor),
        inner = 5 * sharp,
        outer = 13 * sharp;
      for (const [dx, dy] of [
        [1, 0],
        [-1, 0],
        [0, 1],
        [0, -1],
      ]) {
        context.moveTo(x + dx * inner, y + dy * inner);
        context.lineTo(x + dx * outer, y + dy * outer);
      }
    });
}

/**
 * Reads the mouse, the finger and the keys.
 * @param {() => Pixel} size of the picture
 * @param {object} on
 * @param {(at: Pixel | undefined, byKey: boolean) => void} on.move the cross-hair moved; undefined: it left
 * @param {(at: Pixel) => void} on.pick
 * @param {() => void} on.clear
 */
export function listen(size, on) {
  /** @type {Pixel | undefined} */
  let cursor;
  const place = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect(),
      { x: width, y: height } = size();
    const part = (
      /** @type {number} */ at,
      /** @type {number} */ from,
      /** @type {number} */ length,
      /** @type {number} */ n,
    ) => Math.min(n - 1, Math.max(0, Math.floor(((at - from) / length) * n)));
    return { x: part(event.clientX, box.left, box.width, width), y: part(event.clientY, box.top, box.height, height) };
  };
  frame.addEventListener("pointermove", (event) => on.move((cursor = place(event)), false));
  frame.addEventListener("pointerleave", () => on.move(undefined, false));
  frame.addEventListener("click", (event) => {
    cursor = place(/** @type {PointerEvent} */ (event));
    on.pick(cursor);
  });
  /** @type {Record<string, [number, number]>} */
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  frame.addEventListener("keydown", (event) => {
    const { x: width, y: height } = size();
    const at = cursor ?? { x: width >> 1, y: height >> 1 };
    const step = steps[event.key];
    if (step) {
      const by = event.shiftKey ? 10 : 1;
      // The first key shows the cross-hair where it is.
      cursor = cursor
        ? {
            x: Math.min(width - 1, Math.max(0, at.x + by * step[0])),
            y: Math.min(height - 1, Math.max(0, at.y + by * step[1])),
          }
        : at;
      on.move(cursor, true);
    } else if (event.key === "Enter" || event.key === " ") {
      cursor = at;
      on.move(cursor, true);
      on.pick(cursor);
    } else if (event.key === "Escape") {
      on.clear();
    } else {
      return;
    }
    event.preventDefault();
  });
  frame.addEventListener("focus", () => {
    if (frame.matches(":focus-visible")) on.move((cursor ??= { x: size().x >> 1, y: size().y >> 1 }), true);
  });
  frame.addEventListener("blur", () => on.move(undefined, false));
}
