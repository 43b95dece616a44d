#!/usr/bin/env bash
# Measures error against time in the shipped scenes, through its own server.  Writes OUT/NAME/tradeoff.json
# and, if chromium is installed, the first plot of the page, OUT/NAME/errors.png.
#   deploy/tradeoff.sh BUILD_DIR OUT [BUDGET [SEED [NAME...]]]
# BUDGET is the time of each scene, default 120s.  The environment variable QUERY sets the query, default
# irradiance.  SCENES sets the folder of the scenes, default scenes/.  It has NAME/scene.pbrt with a points.csv
# in the same folder, or NAME.pbrt and one points.csv.
# To make the page of a scene: lucerna-tradeoff --report OUT/NAME/tradeoff.json --out DIR
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${1:?usage: deploy/tradeoff.sh BUILD_DIR OUT [BUDGET [SEED [NAME...]]]}" && pwd)
mkdir -p "${2:?usage: deploy/tradeoff.sh BUILD_DIR OUT [BUDGET [SEED [NAME...]]]}"
out=$(cd "$2" && pwd)
budget=${3:-120s}
seed=${4:-1}
shift $(($# < 4 ? $# : 4))
[ $# -gt 0 ] || set -- cornell meadow room stage street
# The reports show paths relative to the sources.
scenes=$(realpath --relative-to="$root" "${SCENES:-$root/scenes}")
cd "$root"
source "$root/deploy/local_server.sh"
start_server "$build" "$scenes"

for scene in "$@"; do
  printf '\n%s\n' "$scene"
  file=$scene/scene.pbrt
  points=$scenes/$scene/points.csv
  [ -f "$scenes/$file" ] || { file=$scene.pbrt; points=$scenes/points.csv; }
  "$build/bin/lucerna-tradeoff" "$file" --query "${QUERY:-irradiance}" --points "$points" \
    --budget "$budget" --seed "$seed" --out "$scratch/$scene"
  mkdir -p "$out/$scene"
  cp "$scratch/$scene/tradeoff.json" "$out/$scene/"
  "$build/bin/lucerna-tradeoff" --report "$out/$scene/tradeoff.json" --out "$scratch/$scene"
  [ ! -f "$scratch/$scene/errors.png" ] || cp "$scratch/$scene/errors.png" "$out/$scene/"
done
