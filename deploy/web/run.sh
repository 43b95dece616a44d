#!/usr/bin/env bash
# Starts lucernad with the demo scene, and lucerna-web in front of it, until Ctrl-C.
#   deploy/web/run.sh BUILD_DIR [LISTEN]
# LISTEN: HOST:PORT for browsers, by default 127.0.0.1:8080.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:?usage: deploy/web/run.sh BUILD_DIR [LISTEN]}" && pwd)
listen=${2:-127.0.0.1:8080}
source "$root/deploy/local_server.sh"

web=
stop_both() {
  [ -z "$web" ] || { kill "$web" 2>/dev/null || true; wait "$web" 2>/dev/null || true; }
  stop_server
}
trap stop_both EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# Loads the demo scene before it serves.  The programs get no Ctrl-C from the terminal: this script stops them in order.
export LUCERNAD_LOAD=demo.pbrt
start_server "$build" "$root/scenes" setsid
: >"$scratch/web" >"$scratch/weblog"
setsid node "$root/build/web/lucerna-web.mjs" --listen "$listen" --server "$LUCERNA_SERVER" --drain-seconds 1 \
  >"$scratch/web" 2>"$scratch/weblog" &
web=$!
for _ in $(seq 1200); do
  address=$(sed -n 's/^listening on //p' "$scratch/web")
  [ -z "$address" ] || break
  kill -0 "$web" 2>/dev/null || { cat "$scratch/weblog"; exit 1; } >&2
  sleep 0.05
done
[ -n "$address" ] || { echo "lucerna-web did not print its address" >&2; exit 1; }
echo "Open $address in a browser.  Ctrl-C stops lucernad and the page."

# Ends with the first of both that ends.
wait -n "$server" "$web" || true
echo "One of the programs ended:" >&2
cat "$scratch/log" "$scratch/weblog" >&2
exit 1
