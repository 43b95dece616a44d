#!/usr/bin/env bash
# Renders the pictures of README's table of lights, docs/lights/NAME.png, from the reference scenes and
# from scenes/.
# Usage: deploy/light_pictures.sh [BUILD_DIR]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${1:-$root/build/release}" && pwd)
export LUCERNA_SERVER=127.0.0.1:${LUCERNA_PORT:-50761}
"$build/server/lucernad" --listen "$LUCERNA_SERVER" --scene-root "$root" &
server=$!
trap 'kill $server; wait $server || true' EXIT
for _ in $(seq 100); do
  "$build/client/lucerna" info > /dev/null 2>&1 && break
  sleep 0.1
done
mkdir -p "$root/docs/lights"
for scene in point spot distant infinite triangle rectangle sphere disk; do
  "$build/client/lucerna" render tests/data/reference/$scene.pbrt -o "$root/docs/lights/$scene.png" --samples 64
done
# Dark or bright ones, and what is not among the reference scenes.
"$build/client/lucerna" render tests/data/reference/goniometric.pbrt -o "$root/docs/lights/goniometric.png" \
  --samples 64 --exposure 2
"$build/client/lucerna" render scenes/wallwasher.pbrt -o "$root/docs/lights/wallwasher.png" \
  --samples 256 --exposure -7
