#!/usr/bin/env bash
# Renders the pictures of the shipped scenes, docs/scenes/NAME.png.
# Usage: deploy/scene_pictures.sh [BUILD_DIR [SAMPLES [NAME...]]].  Default SAMPLES: from the scene files.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${1:-$root/build/release}" && pwd)
samples=(${2:+--samples "$2"})
shift $(($# < 2 ? $# : 2))
[ $# -gt 0 ] || set -- cornell meadow room stage street
source "$root/deploy/local_server.sh"
start_server "$build" "$root/scenes"
mkdir -p "$root/docs/scenes"
for scene in "$@"; do
  "$build/bin/lucerna" render "$scene/scene.pbrt" -o "$root/docs/scenes/$scene.png" "${samples[@]}"
done
