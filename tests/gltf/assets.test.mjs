// Models and environments of the npm package @pmndrs/assets (CC0): the models are compressed with
// Draco, the environments are OpenEXR panoramas from photographs.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import test, { after, before } from "node:test";
import { pathToFileURL } from "node:url";

import {
  facesFromPanorama,
  forFaces,
  forPanorama,
  illuminances,
  panoramaFromTiff,
  png,
} from "./environments.mjs";
import { Server, require, root, run } from "./programs.mjs";

/** A file of the package, whose modules hold data URIs. */
async function asset(path) {
  const module = await import(pathToFileURL(`${root}build/tools/node_modules/@pmndrs/assets/${path}.js`));
  return Buffer.from(module.default.slice(module.default.indexOf(",") + 1), "base64");
}

/** The JSON and the binary part of a .glb file. */
function parts(glb) {
  const length = glb.readUInt32LE(12);
  return { json: JSON.parse(glb.subarray(20, 20 + length)), bin: glb.subarray(28 + length) };
}

const models = ["bunny", "pmndrs", "suzi"];
const environments = ["venice", "dawn", "night"]; // below 255, so that one byte holds the divisor
const faceSize = 128; // as many texels around the horizon as in the panoramas
const intensity = 250; // cd/m2 for a texel of 1
const normals = [1, -1].flatMap((s) => [[s, 0, 0], [0, s, 0], [0, 0, s]]);
const opposite = [3, 4, 5, 0, 1, 2];
// One environment is turned: its +x becomes +y, +y becomes +z, +z becomes +x.
const turned = "dawn";
const beforeTurning = [2, 0, 1, 5, 3, 4]; // of each normal
const triples = (option, vectors) => vectors.map((v) => `--${option}=${v}`);

// Each interval misses its value with a chance of 1e-8.  About 60 are looked at.  The server's
// resampling of the faces changes the values by about 2e-4.
const precise = ["--confidence=99.999999%", "--error=0.5%", "--max-samples=1048576"];

/** Asserts that each interval holds the expected value, and is narrow. */
function assertInside({ lowerLx, upperLx }, expected, what) {
  assert.equal(lowerLx.length, expected.length);
  expected.forEach((value, i) => {
    const interval = `${lowerLx[i]} ... ${upperLx[i]}`;
    assert.ok(upperLx[i] - lowerLx[i] < 0.02 * value, `${what}, ${normals[i]}: ${interval} is wide`);
    assert.ok(lowerLx[i] <= value && value <= upperLx[i], `${what}, ${normals[i]}: ${value}, not ${interval}`);
  });
}

const limit = { timeout: 600_000 };
const panoramas = {}; // by name
const faces = {};
const expected = {}; // the illuminance of an unoccluded surface with each normal
let server;
let outside; // a point beyond each side of the model, in the order of `normals`
before(async () => {
  server = await Server.start();
  const { folder } = server;
  for (const name of models) writeFileSync(`${folder}/${name}.glb`, await asset(`models/${name}.glb`));
  const { json, bin } = parts(readFileSync(`${folder}/suzi.glb`));
  const { min, max } = json.accessors[json.meshes[0].primitives[0].attributes.POSITION];
  outside = normals.map((n) =>
    n.map((c, i) => (c > 0 ? max[i] + 0.1 : c < 0 ? min[i] - 0.1 : (min[i] + max[i]) / 2)),
  );
  writeFileSync(`${folder}/suzi.bin`, bin);
  for (const name of environments) {
    writeFileSync(`${folder}/${name}.exr`, await asset(`hdri/${name}.exr`));
    const tiff = ["-d", "float", "--compression", "none", "-o", `${folder}/${name}.tif`];
    const made = await run("oiiotool", `${folder}/${name}.exr`, ...tiff);
    assert.equal(made.status, 0, made.stderr + made.stdout);
    panoramas[name] = panoramaFromTiff(readFileSync(`${folder}/${name}.tif`));
    faces[name] = facesFromPanorama(panoramas[name], faceSize);
    faces[name].forEach((texels, f) => writeFileSync(`${folder}/${name}${f}.png`, png(faceSize, texels)));
    expected[name] = underFaces(name);
    writeFileSync(`${folder}/${name}.gltf`, JSON.stringify(lit(json, bin, name)));
    writeFileSync(
      `${folder}/${name}.pbrt`,
      `WorldBegin LightSource "infinite" "string filename" "${name}.exr" "string mapping" "latlong"`,
    );
  }
}, limit);
after(() => server?.stop());

/** The model in an environment, with a camera in front of it. */
function lit(json, bin, name) {
  const light = {
    name,
    intensity,
    rotation: name === turned ? [0.5, 0.5, 0.5, 0.5] : [0, 0, 0, 1],
    irradianceCoefficients: Array(9).fill([0, 0, 0]), // not used
    specularImageSize: faceSize,
    specularImages: [[0, 1, 2, 3, 4, 5]],
  };
  const eye = { name: "eye", camera: 0, translation: [0, 0, 4] };
  return {
    ...json,
    buffers: [{ byteLength: bin.length, uri: "suzi.bin" }],
    images: faces[name].map((_, f) => ({ uri: `${name}${f}.png` })),
    // A narrow picture has few pixels: the height is always 720.
    cameras: [{ type: "perspective", perspective: { yfov: 0.5, aspectRatio: 0.1, znear: 0.1 } }],
    nodes: [...json.nodes, eye],
    scenes: [
      { nodes: [...json.scenes[0].nodes, json.nodes.length], extensions: { EXT_lights_image_based: { light: 0 } } },
    ],
    extensionsUsed: [...json.extensionsUsed, "EXT_lights_image_based"],
    extensions: { EXT_lights_image_based: { lights: [light] } },
  };
}

/** The illuminance of unoccluded surfaces under the faces. */
function underFaces(name, mirrored) {
  const values = illuminances(normals, (visit) => forFaces(faces[name], faceSize, visit, mirrored));
  return normals.map((_, i) => intensity * values[name === turned ? beforeTurning[i] : i]);
}

test("each model has the triangles and the size that its accessors say", limit, async () => {
  for (const name of models) {
    const { json } = parts(readFileSync(`${server.folder}/${name}.glb`));
    const [{ indices, attributes, extensions }] = json.meshes[0].primitives;
    assert.ok(extensions.KHR_draco_mesh_compression, name);
    const { summary, remarks } = await server.answer("inspect", `${name}.glb`);
    assert.equal(Number(summary.primitives), json.accessors[indices].count / 3, name);
    assert.deepEqual(remarks.map(({ what }) => what), ["the scene has no camera"], name);
    // Draco rounds positions, by default to 11 bits.
    const { min, max } = json.accessors[attributes.POSITION];
    const rounding = Math.max(...max.map((m, i) => m - min[i])) / 2 ** 11;
    ["x", "y", "z"].forEach((axis, i) => {
      const error = Math.abs(summary.centerM[axis] - (min[i] + max[i]) / 2);
      assert.ok(error <= rounding, `${name}: ${axis} of the centre`);
    });
    const radius = Math.hypot(...max.map((m, i) => m - min[i])) / 2;
    assert.ok(Math.abs(summary.radiusM - radius) <= 2 * rounding, `${name}: radius`);
  }
});

test("points beside the model get the light of half the environment", limit, async (t) => {
  const tops = [];
  for (const name of environments) {
    const { remarks, contents } = await server.answer("inspect", `${name}.gltf`);
    assert.deepEqual(remarks, [], name);
    assert.deepEqual(contents.shapes.map(({ primitives }) => primitives), ["14842"]);
    const answer = await server.answer(
      "irradiance", `${name}.gltf`, ...precise, ...triples("point", outside), ...triples("normal", normals),
    );
    const off = expected[name].map((value, i) => Math.abs(answer.illuminanceLx[i] / value - 1));
    t.diagnostic(`${name}: ${answer.illuminanceLx} lx; off by ${Math.max(...off)}; ${answer.cost.samples} samples`);
    assertInside(answer, expected[name], name);
    // A mirrored environment is noticed.
    assert.throws(() => assertInside(answer, underFaces(name, false), name), /, not /);
    tops.push([answer.lowerLx[1], answer.upperLx[1]]);
  }
  tops.sort(([a], [b]) => a - b);
  assert.ok(tops[0][1] < tops[1][0] && tops[1][1] < tops[2][0], `${tops} differ`);
});

test("points that face the model get some light, but less", limit, async () => {
  const inward = normals.map((n) => n.map((c) => 0 - c));
  for (const name of environments) {
    const ask = (...more) =>
      server.answer("irradiance", `${name}.gltf`, ...triples("point", outside), ...triples("normal", inward), ...more);
    const direct = await ask("--bounces=0");
    const all = await ask();
    opposite.forEach((back, i) => {
      const value = expected[name][back];
      assert.ok(direct.lowerLx[i] > 0 && direct.upperLx[i] < value, `${name}: ${direct.upperLx[i]} lx of ${value}`);
      assert.ok(all.lowerLx[i] > 0 && Number.isFinite(all.upperLx[i]), `${name}: ${all.illuminanceLx[i]} lx`);
    });
  }
});

test("a picture of each environment has no NaN", limit, async () => {
  for (const name of environments) {
    const file = `${server.folder}/${name}.pfm`;
    const options = ["--samples=16", "--bounces=2", "-o", file];
    const { status, stderr } = await server.lucerna("render", `${name}.gltf`, ...options);
    assert.equal(status, 0, stderr);
    const bytes = readFileSync(file);
    const pixels = 3 * 72 * 720;
    const texels = bytes.subarray(bytes.length - 4 * pixels);
    assert.match(bytes.subarray(0, bytes.length - 4 * pixels).toString(), /^PF\s72 720\s-1/);
    const values = Array.from({ length: pixels }, (_, i) => texels.readFloatLE(4 * i));
    assert.ok(values.every((value) => Number.isFinite(value) && value >= 0), name);
    assert.ok(values.filter((value) => value > 0).length > 0.999 * pixels, name);
  }
});

test("the panorama itself gives the same light", limit, async () => {
  for (const name of environments) {
    const values = illuminances(normals, (visit) => forPanorama(panoramas[name], visit));
    const answer = await server.answer(
      "irradiance", `${name}.pbrt`, ...precise, ...triples("point", outside), ...triples("normal", normals),
    );
    assertInside(answer, values, name);
    // The faces of the other tests show the same environment.  Their texels have a few steps of 1/255.
    values.forEach((value, i) => {
      const other = expected[name][name === turned ? beforeTurning.indexOf(i) : i] / intensity;
      assert.ok(Math.abs(other / value - 1) < 0.01, `${name}, ${normals[i]}: ${other} and ${value}`);
    });
  }
});
