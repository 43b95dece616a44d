// Lucerna and Khronos' glTF validator agree on which files are valid.
//
// The rule: a file without errors loads, and a file with errors is refused.  Two tables below list
// each exception, and an entry that is not needed fails.  Lucerna's error names the file and a
// place where the validator finds an error.
import assert from "node:assert/strict";
import { existsSync, readdirSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { basename, dirname, resolve } from "node:path";
import test, { after, before } from "node:test";

import { Server, require, root } from "./programs.mjs";

const validator = require("gltf-validator");

const models = "/usr/share/assimp/models/"; // Debian's package assimp-testmodels
const own = `${root}tests/data/gltf/`;

/** Valid files that Lucerna refuses, and its reason. */
const refusedThoughValid = {
  "glTF2/BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf":
    '#/extensionsRequired/0: the file requires the extension "KHR_technique_webgl", which is not modelled',
};

/** Invalid files that Lucerna loads, and the validator's codes. */
const loadedThoughInvalid = {
  // Normals without a direction: a remark, and the mesh is flat.  Nothing reads the wrong bounds.
  "glTF2/BoxBadNormals-glTF-Binary/BoxBadNormals.glb": [
    "ACCESSOR_MAX_MISMATCH",
    "ACCESSOR_MIN_MISMATCH",
    "ACCESSOR_VECTOR3_NON_UNIT",
  ],
  // A normal map of a clearcoat, which a remark says is not applied.
  "glTF2/ClearCoat-glTF/ClearCoatTest.gltf": ["MESH_PRIMITIVE_NO_TANGENT_SPACE"],
  // No mesh uses the parts that are too long.  Nothing reads the wrong or missing bounds.
  "glTF2/IncorrectVertexArrays/Cube.gltf": [
    "ACCESSOR_MAX_MISMATCH",
    "BUFFER_VIEW_TOO_LONG",
    "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE",
    "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS",
  ],
  // The (u, v) of a texture are missing: a remark, and all points have the (u, v) 0, 0.
  "glTF2/issue_3269/texcoord_crash.gltf": [
    "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY",
    "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
  ],
};

/** The glTF files beneath a folder, in order. */
const filesOf = (folder) =>
  readdirSync(folder, { recursive: true })
    .filter((name) => /\.(gltf|glb)$/.test(name))
    .sort();

/** The validator's errors: codes and JSON pointers.  Files that the scene names are read too. */
async function errorsOf(path) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(path)), {
    uri: basename(path),
    format: path.endsWith(".glb") ? "glb" : "gltf",
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(resolve(dirname(path), decodeURIComponent(uri)))),
  });
  return report.issues.messages.filter((message) => message.severity === 0);
}

/** What each program says about a file.  `refusal` is null if Lucerna loads it. */
async function verdict(path, name, ...load) {
  const errors = await errorsOf(path);
  const { status, stderr } = await server.lucerna("load", ...load);
  assert.ok(status === 0 || status === 1, `lucerna load ${load.join(" ")}: ${status} ${stderr}`);
  return {
    name,
    codes: [...new Set(errors.map(({ code }) => code))].sort(),
    pointers: new Set(errors.flatMap(({ pointer }) => (pointer ? [pointer] : []))),
    refusal: status === 0 ? null : stderr.trim().replace(/^lucerna: the server reported \w+: /, ""),
  };
}

/** The places where verdicts break the rule, and the entries of the tables that nothing needs. */
function breaches(verdicts, refused, loaded) {
  const found = [];
  const needed = new Set();
  for (const { name, codes, pointers, refusal } of verdicts) {
    if (codes.length === 0 && refusal !== null) {
      needed.add(name);
      if (!(name in refused)) found.push(`${name} is valid, but refused: ${refusal}`);
      else if (refusal !== name + refused[name]) found.push(`${name} has another reason: ${refusal}`);
    } else if (codes.length > 0 && refusal === null) {
      needed.add(name);
      if (!(name in loaded)) found.push(`${name} loads in spite of ${codes}`);
      else if (`${loaded[name]}` !== `${codes}`) found.push(`${name} has the errors ${codes}`);
    } else if (refusal !== null) {
      if (!refusal.startsWith(name)) found.push(`${name} is not named: ${refusal}`);
      const place = /^#([^: ]*)/.exec(refusal.slice(name.length))?.[1];
      if (pointers.size > 0 && !pointers.has(place))
        found.push(`${name}: the validator finds errors at ${[...pointers]}, Lucerna: ${refusal}`);
    }
  }
  for (const name of [...Object.keys(refused), ...Object.keys(loaded)])
    if (!needed.has(name)) found.push(`${name} needs no entry`);
  return found;
}

const limit = { timeout: 600_000 };
const skip = !existsSync(models) && "assimp-testmodels is not installed";
let server;
const verdicts = []; // on Debian's models
before(async () => {
  server = await Server.start(skip ? undefined : models);
  if (!skip)
    for (const name of filesOf(models)) verdicts.push(await verdict(models + name, name, name));
}, limit);
after(() => server?.stop());

test("both agree on Debian's models", { skip }, (t) => {
  assert.deepEqual(breaches(verdicts, refusedThoughValid, loadedThoughInvalid), []);
  const loaded = verdicts.filter(({ refusal }) => refusal === null).length;
  t.diagnostic(`${verdicts.length} models, of which ${loaded} load`);
  assert.ok(loaded >= 25 && verdicts.length - loaded >= 20, `${loaded} of ${verdicts.length} load`);
});

test("both agree on the models of the tests", limit, async () => {
  const names = filesOf(own);
  assert.notEqual(names.length, 0);
  const found = [];
  for (const name of names) found.push(await verdict(own + name, name, "--upload", own + name));
  assert.deepEqual(breaches(found, {}, {}), []);
});

test("a wrong verdict and a wrong place are noticed, in each file", { skip }, () => {
  for (const [i, { name, codes, refusal }] of verdicts.entries()) {
    const noticed = (change) => {
      const changed = verdicts.map((one, j) => (j === i ? { ...one, ...change } : one));
      const found = breaches(changed, refusedThoughValid, loadedThoughInvalid);
      assert.notEqual(found.length, 0, `${name} with ${JSON.stringify(change)}`);
    };
    noticed({ refusal: refusal === null ? `${name}#/asset: bad` : null });
    noticed({ codes: codes.length > 0 ? [] : ["IO_ERROR"] });
    if (refusal !== null) noticed({ refusal: `other/${refusal}` });
    if (refusal?.includes("#")) noticed({ refusal: `${name}#/scenes/7: bad` });
  }
});

test("an entry that is missing or not needed is noticed", { skip }, () => {
  const without = (table, name) =>
    Object.fromEntries(Object.entries(table).filter(([other]) => other !== name));
  for (const name of Object.keys(refusedThoughValid))
    assert.equal(breaches(verdicts, without(refusedThoughValid, name), loadedThoughInvalid).length, 1);
  for (const name of Object.keys(loadedThoughInvalid))
    assert.equal(breaches(verdicts, refusedThoughValid, without(loadedThoughInvalid, name)).length, 1);
  const box = "glTF2/BoxTextured-glTF/BoxTextured.gltf";
  assert.equal(breaches(verdicts, { ...refusedThoughValid, [box]: "" }, loadedThoughInvalid).length, 1);
  assert.equal(breaches(verdicts, refusedThoughValid, { ...loadedThoughInvalid, [box]: [] }).length, 1);
});
