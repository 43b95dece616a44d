#!/usr/bin/env bash
# Measures error against time in the shipped scenes on a server of its own, to
# OUT/NAME/{report.html,tradeoff.csv,tradeoff.json}.
#   deploy/tradeoff.sh BUILD_DIR OUT [BUDGET [SEED [NAME...]]]
# BUDGET: per scene, default 120s.  QUERY in the environment selects another query than irradiance.
# SCENES selects another folder than scenes/: NAME/scene.pbrt with points.csv beside it, or
# NAME.pbrt.  If chromium is installed, it also writes OUT/NAME/errors.png, a picture of the page's
# first plot.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${1:?usage: deploy/tradeoff.sh BUILD_DIR OUT [BUDGET [SEED [NAME...]]]}" && pwd)
mkdir -p "${2:?usage: deploy/tradeoff.sh BUILD_DIR OUT [BUDGET [SEED [NAME...]]]}"
out=$(cd "$2" && pwd)
budget=${3:-120s}
seed=${4:-1}
shift $(($# < 4 ? $# : 4))
[ $# -gt 0 ] || set -- cornell meadow room stage street
# The reports have paths relative to the sources.
scenes=$(realpath --relative-to="$root" "${SCENES:-$root/scenes}")
cd "$root"
source "$root/deploy/local_server.sh"
start_server "$build" "$scenes"

for scene in "$@"; do
  printf '\n%s\n' "$scene"
  file=$scene/scene.pbrt
  points=$scenes/$scene/points.csv
  [ -f "$scenes/$file" ] || { file=$scene.pbrt; points=$scenes/points.csv; }
  "$build/bin/lucerna" tradeoff "$file" --query "${QUERY:-irradiance}" --points "$points" \
    --budget "$budget" --seed "$seed" --out "$out/$scene"
  command -v chromium >/dev/null || continue
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --force-device-scale-factor=1.5 --window-size=1000,660 \
    --screenshot="$out/$scene/errors.png" "file://$out/$scene/report.html#only=errors" 2>"$scratch/chromium" || cat "$scratch/chromium" >&2
done
