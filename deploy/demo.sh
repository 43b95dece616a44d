#!/usr/bin/env bash
# Starts lucernad with the shipped scenes, runs four queries, renders a picture, and stops the
# server.
#   deploy/demo.sh BUILD_DIR [OUTPUT_DIR [SAMPLES]]
# OUTPUT_DIR: default build/demo.  SAMPLES of each pixel: default from the scene file.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${1:?usage: deploy/demo.sh BUILD_DIR [OUTPUT_DIR]}" && pwd)
output=${2:-$root/build/demo}
samples=(${3:+--samples "$3"})
mkdir -p "$output"
output=$(cd "$output" && pwd)
export PATH=$build/bin:$PATH
source "$root/deploy/local_server.sh"
# If the demo itself is killed, the server stops after an hour.  -k kills it if it does not stop.
start_server "$build" "$root/scenes" timeout -k 5 3600
echo "lucernad runs at $LUCERNA_SERVER, scene root scenes/."

run() { printf '\n$ lucerna %s\n' "$*"; lucerna "$@"; }

printf '\nThe scene and its lights.\n'
run load demo.pbrt
run lights demo.pbrt

printf '\n1. Sample_L: light from the panel that arrives on the floor, and whether anything is between.\n'
run sample demo.pbrt --point 0,-1.5,0 --normal 0,0,1 --light 3 --samples 4 --visible

printf '\n2. Power: what each light emits.\n'
run power demo.pbrt

printf '\n3. Visibility and irradiance: does the bulb see the floor, and what does a lux meter read?\n'
run visible demo.pbrt --point 2.35,1.75,0.35 --point 2.35,1.75,0.35 --to 2.6,1.8,0 --to 0,-1.5,0
run irradiance demo.pbrt --point 0,-1.5,0 --point 0,1,0 --point 0.35,-0.85,0.58 --normal 0,0,1 \
  --samples 1024 --per-light

printf '\n4. The picture.\n'
cd "$output"
run render demo.pbrt -o demo.png -o demo.exr --stderr demo.stderr.exr --exposure -6 "${samples[@]}"
printf '\nThe picture: %s, and in linear light %s\n' "$output/demo.png" "$output/demo.exr"
