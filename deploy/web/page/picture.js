// The picture of a scene while it renders, with the error of each pixel.
import { renders } from "./api.js";

/** Rec. 709. */
const weights = [0.2126, 0.7152, 0.0722];
/** Half the width of an interval of 95 %, in standard errors. */
const z95 = 1.96;

export class Picture {
  /** Radiance [cd/m2], three channels for each pixel. */ rgb;
  /** Luminance [cd/m2]. */ luminance;
  /** Half the width of the luminance's 95 % interval, relative to it; NaN where it is not known. */ error;

  constructor(/** @type {number} */ width, /** @type {number} */ height, /** @type {number} */ filmScale) {
    this.width = width;
    this.height = height;
    this.filmScale = filmScale;
    this.rgb = new Float32Array(3 * width * height);
    this.luminance = new Float32Array(width * height);
    this.error = new Float32Array(width * height).fill(NaN);
    /** Whether any tile has arrived. */
    this.started = false;
  }

  /** Takes a tile, which replaces the one before. */
  put(/** @type {import("../../generated/lucerna/v1/render_pb.js").Tile} */ tile) {
    const { x0, y0, x1, y1 } = /** @type {import("../../generated/lucerna/v1/render_pb.js").PixelRect} */ (tile.rect);
    const n = Number(tile.blockCount);
    const sums = new DataView(tile.sum.buffer, tile.sum.byteOffset, tile.sum.byteLength);
    const deviations = new DataView(tile.deviation.buffer, tile.deviation.byteOffset, tile.deviation.byteLength);
    let at = 0;
    for (let y = y0; y < y1; ++y)
      for (let x = x0; x < x1; ++x) {
        const pixel = y * this.width + x;
        let luminance = 0,
          error = 0;
        for (let c = 0; c < 3; ++c, at += 8) {
          const value = sums.getFloat64(at, true) / n / this.filmScale;
          this.rgb[3 * pixel + c] = value;
          luminance += weights[c] * value;
          // The channels of a pixel err together, so their errors add up.
          error += weights[c] * Math.sqrt(deviations.getFloat64(at, true) / (n * (n - 1)));
        }
        this.luminance[pixel] = luminance;
        this.error[pixel] = n > 1 && luminance > 0 ? (z95 * error) / this.filmScale / luminance : NaN;
      }
    this.started = true;
  }

  /** The median of the relative errors, of at most some thousand pixels; NaN if none is known. */
  medianError() {
    const step = Math.max(1, Math.floor(this.error.length / 4001));
    const some = [];
    for (let i = 0; i < this.error.length; i += step) if (this.error[i] >= 0) some.push(this.error[i]);
    some.sort((a, b) => a - b);
    return some.length ? some[some.length >> 1] : NaN;
  }

  /** The luminance below which a share of the pixels lies [cd/m2]. */
  quantile(/** @type {number} */ share) {
    const step = Math.max(1, Math.floor(this.luminance.length / 20011));
    const some = [];
    for (let i = 0; i < this.luminance.length; i += step) if (this.luminance[i] > 0) some.push(this.luminance[i]);
    some.sort((a, b) => a - b);
    return some.length ? some[Math.min(some.length - 1, Math.floor(share * some.length))] : 0;
  }
}

/**
 * Renders the picture of a scene.  Calls `progress` after each message.
 * @param {string} sceneId
 * @param {number} samples of each pixel, a power of two
 * @param {Picture} picture
 * @param {AbortSignal} signal
 * @param {(answer: import("../../generated/lucerna/v1/render_pb.js").RenderImageResponse) => void} progress
 */
export async function render(sceneId, samples, picture, signal, progress) {
  const stream = renders.renderImage(
    {
      sceneId,
      accuracy: { stop: { case: "samples", value: samples } },
      // Small blocks, so that the first picture appears early.
      samplesPerBlock: Math.max(1, Math.min(4, samples / 8)),
    },
    { signal },
  );
  for await (const answer of stream) {
    if (answer.tile) picture.put(answer.tile);
    progress(answer);
  }
}
