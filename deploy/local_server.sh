# shellcheck shell=bash
# Source this file to run a lucernad on a free port of this machine until the script ends.
#   start_server BUILD_DIR SCENE_ROOT [WRAPPER...]
# Exports LUCERNA_SERVER, the server's address.  $scratch is a temporary folder that is deleted with
# the server.  WRAPPER: a command that runs lucernad, such as timeout.

scratch=$(mktemp -d)
server=
stop_server() {
  [ -z "$server" ] || { kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; }
  rm -rf "$scratch"
}
trap stop_server EXIT

start_server() {
  local build=$1 scenes=$2
  shift 2
  : >"$scratch/out"
  "$@" "$build/bin/lucernad" --listen 127.0.0.1:0 --scene-root "$scenes" >"$scratch/out" 2>"$scratch/log" &
  server=$!
  LUCERNA_SERVER=
  for _ in $(seq 3600); do
    LUCERNA_SERVER=$(sed -n 's/^listening on //p' "$scratch/out")
    [ -z "$LUCERNA_SERVER" ] || break
    kill -0 "$server" 2>/dev/null || { echo "lucernad did not start:"; cat "$scratch/log"; exit 1; } >&2
    sleep 0.05
  done
  [ -n "$LUCERNA_SERVER" ] || { echo "lucernad did not print its address" >&2; exit 1; }
  export LUCERNA_SERVER
}
