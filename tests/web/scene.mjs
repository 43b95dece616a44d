// A small scene for tests of the page: two lamps over a floor, before a wall.
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";

const text = `
Film "rgb" "integer xresolution" [60] "integer yresolution" [40]
Sampler "zsobol" "integer pixelsamples" [4]
Integrator "path" "integer maxdepth" [2]
LookAt 0 -6 4  0 0 0.3  0 0 1
Camera "perspective" "float fov" [46]
WorldBegin
LightSource "point" "string name" "left" "rgb I" [100 100 100] "point3 from" [-1 0 2]
LightSource "point" "string name" "right" "rgb I" [60 45 30] "point3 from" [1 0 2]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "bilinearmesh" "point3 P" [-5 -5 0  5 -5 0  -5 2 0  5 2 0]
Shape "bilinearmesh" "point3 P" [-2 2 0  2 2 0  -2 2 4  2 2 4]
`;

/** Makes a folder with the scene, in the file lamps.pbrt, and a wrong one in broken.pbrt. */
export function makeScenes() {
  const folder = mkdtempSync(`${tmpdir()}/lucerna-web-scenes.`);
  writeFileSync(`${folder}/lamps.pbrt`, text);
  writeFileSync(`${folder}/broken.pbrt`, text.replace("[100 100 100]", "[100 100 many]"));
  return folder;
}
