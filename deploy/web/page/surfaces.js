// The surfaces that the picture shows.
import { renders } from "./api.js";
import { limits } from "./session.js";

/** @typedef {import("./geometry.js").Place} Place */

/** The surface in the middle of a pixel; undefined if there is none. */
export async function surfaceAt(
  /** @type {string} */ sceneId,
  /** @type {number} */ x,
  /** @type {number} */ y,
  /** @type {AbortSignal} */ signal,
) {
  const answer = await renders.findSurfaces({ sceneId, places: [x + 0.5, y + 0.5] }, { signal });
  return placeOf(answer, 0);
}

/**
 * @param {import("../../generated/lucerna/v1/render_pb.js").FindSurfacesResponse} answer
 * @param {number} i
 * @returns {Place | undefined}
 */
function placeOf({ points, normals, found }, i) {
  if (!(found[i >> 3] & (1 << (i & 7)))) return undefined;
  const origin = points?.originM,
    offsets = points?.offsetsM ?? [];
  return {
    point: [
      (origin?.x ?? 0) + offsets[3 * i],
      (origin?.y ?? 0) + offsets[3 * i + 1],
      (origin?.z ?? 0) + offsets[3 * i + 2],
    ],
    normal: [normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]],
  };
}

/** The surfaces of all pixels, or of every second or third one in large pictures. */
export class SurfaceMap {
  static #most = 150_000;

  /** @type {(Place | undefined)[]} */ #places = [];

  /** @private */
  constructor(/** @type {number} */ width, /** @type {number} */ height) {
    this.step = Math.max(1, Math.ceil(Math.sqrt((width * height) / SurfaceMap.#most)));
    this.columns = Math.ceil(width / this.step);
    this.rows = Math.ceil(height / this.step);
  }

  static async read(
    /** @type {string} */ sceneId,
    /** @type {number} */ width,
    /** @type {number} */ height,
    /** @type {AbortSignal} */ signal,
  ) {
    const map = new SurfaceMap(width, height);
    const rowsAtOnce = Math.max(1, Math.floor(Math.min(limits?.maxBatchItems ?? 1024, 32768) / map.columns));
    for (let from = 0; from < map.rows; from += rowsAtOnce) {
      const places = [];
      const to = Math.min(map.rows, from + rowsAtOnce);
      for (let j = from; j < to; ++j)
        for (let i = 0; i < map.columns; ++i)
          places.push(Math.min((i + 0.5) * map.step, width), Math.min((j + 0.5) * map.step, height));
      const answer = await renders.findSurfaces({ sceneId, places }, { signal });
      for (let k = 0; k < places.length / 2; ++k) map.#places.push(placeOf(answer, k));
    }
    return map;
  }

  /** The surface near a pixel. */
  at(/** @type {number} */ x, /** @type {number} */ y) {
    return this.cell(Math.floor(x / this.step), Math.floor(y / this.step));
  }
  cell(/** @type {number} */ i, /** @type {number} */ j) {
    return this.#places[j * this.columns + i];
  }
}
