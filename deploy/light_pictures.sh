#!/usr/bin/env bash
# Renders the pictures of the table of lights, docs/lights/NAME.png, from the reference scenes and
# from scenes/.  For lights that pbrt-v4 does not have, it adds a parameter to a light of a reference
# scene.
#   deploy/light_pictures.sh [BUILD_DIR]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${1:-$root/build/release}" && pwd)
source "$root/deploy/local_server.sh"
scenes=$scratch/scenes
mkdir -p "$scenes/tests/data"
cp -r "$root/scenes" "$scenes"
cp -r "$root/tests/data/reference" "$scenes/tests/data"
with() { sed "$3" "$scenes/tests/data/reference/$2.pbrt" > "$scenes/tests/data/reference/$1.pbrt"; }  # NAME FROM EXPRESSION
with sun distant 's/LightSource "distant"/& "float angulardiameter" [8]/'
with beam projection 's/"float fov" .38. "float scale" .60./"string projection" ["orthographic"] "float extent" [1.6] "float scale" [5]/'
start_server "$build" "$scenes"
mkdir -p "$root/docs/lights"
for scene in point spot projection beam distant sun infinite environment triangle rectangle sphere disk cylinder textured; do
  "$build/bin/lucerna" render tests/data/reference/$scene.pbrt -o "$root/docs/lights/$scene.png" --samples 64
done
# Dark or bright scenes, and scenes that are not reference scenes.
"$build/bin/lucerna" render tests/data/reference/goniometric.pbrt -o "$root/docs/lights/goniometric.png" \
  --samples 64 --exposure 2
"$build/bin/lucerna" render tests/data/reference/portal.pbrt -o "$root/docs/lights/portal.png" \
  --samples 256 --exposure 1
"$build/bin/lucerna" render scenes/wallwasher.pbrt -o "$root/docs/lights/wallwasher.png" \
  --samples 256 --exposure -7
"$build/bin/lucerna" render scenes/panel.pbrt -o "$root/docs/lights/panel.png" \
  --samples 256 --exposure -7
"$build/bin/lucerna" render scenes/moving.pbrt -o "$root/docs/lights/moving.png" --samples 256 --exposure -1
