// The open scene, its lights as the user dims them, and the leases that keep it loaded.
import { scenes, lighting, kindOf } from "./api.js";

const leaseSeconds = 60;
const renewEveryMs = 20_000;

/** @typedef {import("../../generated/lucerna/v1/light_pb.js").Light} Light */
/** @typedef {import("../../generated/lucerna/v1/scene_pb.js").SceneSummary} Summary */
/** @typedef {{scale: number, on: boolean}} Level */
/** @typedef {{id: string, lease: string}} Kept a scene on the server, and our lease */

/** All pages of a list. */
async function allPages(/** @type {(token: string) => Promise<{nextPageToken: string}>} */ call) {
  const pages = [];
  let token = "";
  do {
    const page = await call(token);
    pages.push(page);
    token = page.nextPageToken;
  } while (token);
  return /** @type {any[]} */ (pages);
}

/**
 * The names of scenes that can be opened: loaded ones first, each with its id.  `denied`: the token may not list files.
 */
export async function listScenes() {
  const loaded = (await allPages((pageToken) => scenes.listScenes({ pageToken }))).flatMap((page) => page.scenes);
  /** @type {{path: string, id?: string, lights?: bigint}[]} */
  const result = loaded.filter((s) => !s.loadedSceneId).map((s) => ({ path: s.path, id: s.sceneId, lights: s.lights }));
  let denied = false;
  try {
    const names = new Set(result.map((s) => s.path));
    for (const { paths } of await allPages((pageToken) => scenes.listAvailableScenes({ pageToken })))
      for (const path of paths) if (!names.has(path)) result.push({ path });
  } catch (error) {
    if (kindOf(error) !== "denied") throw error;
    denied = true;
  }
  return { scenes: result, denied };
}

/** The unit of the illuminance by a light whose flux has this unit. */
export const illuminanceUnitOf = (/** @type {string} */ flux) =>
  flux === "lm" ? "lx" : flux === "unknown" ? "unknown unit" : `${flux}/m²`;

export class OpenScene {
  /** @type {Kept} */ #base;
  /** @type {Kept} */ #revision;
  /** @type {Map<bigint, Level>} */ #levels = new Map();
  #mayEdit = true;
  #timer = 0;
  /** Set while an edit runs; then whether another one must follow. */
  #editing = false;
  #again = false;

  /** @type {string} */ path;
  /** @type {Summary} */ summary;
  /** @type {Light[]} */ lights = [];
  /** Luminous flux and colour of each light, in the order of `lights`. */
  /** @type {{lumens: number, unit: string, rgb: [number, number, number]}[]} */ powers = [];
  /** What the file holds that is not modelled. */
  remarks = 0;

  /** @private */
  constructor(
    /** @type {string} */ path,
    /** @type {Kept} */ base,
    /** @type {Summary} */ summary,
    /** @type {boolean} */ mayEdit,
  ) {
    this.path = path;
    this.#base = this.#revision = base;
    this.summary = summary;
    this.#mayEdit = mayEdit;
  }

  /** Opens a scene by its name, or by its id if the caller may not load scenes. */
  static async open(/** @type {string} */ path, /** @type {string | undefined} */ id) {
    /** @type {Kept} */
    let base;
    let mayEdit = true;
    try {
      const loaded = await scenes.loadScene({ source: { case: "path", value: path }, leaseS: leaseSeconds });
      base = { id: loaded.sceneId, lease: loaded.leaseId };
    } catch (error) {
      if (kindOf(error) !== "denied" || !id) throw error;
      base = { id, lease: "" };
      mayEdit = false;
    }
    const { summary, remarks } = await scenes.getScene({ sceneId: base.id });
    if (!summary) throw new Error("the answer of GetScene has no summary");
    const scene = new OpenScene(path, base, summary, mayEdit);
    scene.remarks = remarks.reduce((sum, remark) => sum + Number(remark.count), 0);
    await scene.#readLights();
    scene.#timer = window.setInterval(() => scene.#renew(), renewEveryMs);
    return scene;
  }

  async #readLights() {
    const sceneId = this.#base.id;
    this.lights = (await allPages((pageToken) => scenes.listLights({ sceneId, pageToken }))).flatMap((p) => p.lights);
    this.powers = (await allPages((pageToken) => lighting.estimatePower({ sceneId, pageToken })))
      .flatMap((p) => p.lights)
      .map(({ powerLm, powerUnit, rgbLm }) => ({
        lumens: powerLm,
        unit: powerUnit || "lm",
        rgb: [rgbLm?.r ?? 0, rgbLm?.g ?? 0, rgbLm?.b ?? 0],
      }));
  }

  /** The unit of illuminances, of all lights together: lx, or that of photometric files in mW/sr and the like. */
  get illuminanceUnit() {
    const units = new Set(this.powers.map(({ unit }) => illuminanceUnitOf(unit)));
    return units.size > 1 ? "mixed units" : ([...units][0] ?? "lx");
  }

  /** The id for queries: that of the revision with the levels of the user. */
  get id() {
    return this.#revision.id;
  }
  get isEdited() {
    return this.#revision !== this.#base;
  }
  get mayEdit() {
    return this.#mayEdit;
  }
  level(/** @type {bigint} */ light) {
    return this.#levels.get(light) ?? { scale: 1, on: true };
  }
  setLevel(/** @type {bigint} */ light, /** @type {Level} */ level) {
    if (level.scale === 1 && level.on) this.#levels.delete(light);
    else this.#levels.set(light, level);
  }
  resetLevels() {
    this.#levels.clear();
  }

  /**
   * Makes the revision that has the levels of now, and releases the one before.  Calls during an edit are joined to one
   * edit after it.  True if the revision is another one.
   */
  async applyLevels() {
    if (this.#editing) {
      this.#again = true;
      return false;
    }
    this.#editing = true;
    const before = this.#revision;
    try {
      do {
        this.#again = false;
        const next = await this.#edited();
        const last = this.#revision;
        this.#revision = next;
        if (last !== this.#base && last.id !== next.id) this.#release(last);
      } while (this.#again);
    } finally {
      this.#editing = false;
    }
    return this.#revision.id !== before.id;
  }

  async #edited() {
    if (this.#levels.size === 0) return this.#base;
    const edits = [...this.#levels].map(([lightId, { scale, on }]) => ({
      edit: { case: /** @type {const} */ ("change"), value: { lightId, scale, on } },
    }));
    const made = await scenes.editLights({ sceneId: this.#base.id, edits, leaseS: leaseSeconds });
    return { id: made.sceneId, lease: made.leaseId };
  }

  #release(/** @type {Kept} */ { id, lease }) {
    // Without an answer, the lease ends by itself.
    if (lease) scenes.releaseScene({ sceneId: id, leaseId: lease }).catch(() => {});
  }

  #renew() {
    for (const { id, lease } of new Set([this.#base, this.#revision]))
      if (lease) scenes.renewLease({ sceneId: id, leaseId: lease, leaseS: leaseSeconds }).catch(() => {});
  }

  /** The levels, for the same scene after the server has started again. */
  takeLevels(/** @type {OpenScene} */ from) {
    for (const [light, level] of from.#levels)
      if (this.lights.some(({ id }) => id === light)) this.#levels.set(light, level);
  }

  /** Releases the revision.  The server keeps the scene of the file while it has memory for it. */
  close() {
    clearInterval(this.#timer);
    if (this.#revision !== this.#base) this.#release(this.#revision);
  }
}
