#!/usr/bin/env bash
# Builds lucerna-web into build/web: lucerna-web.mjs, the gateway, and site/, the page.  Both need only Node to run.
#   deploy/web/build.sh [--check]
# --check: also checks the types of all sources.  Needs Node with npm, and Debian's protobuf-compiler.
set -euo pipefail
cd "$(dirname "$0")/../.."

out=build/web
mkdir -p "$out/generated" "$out/site"
# Sources are compiled through this link, so that they find the packages beside it.
ln -sfn ../../deploy/web "$out/source"

# npm ci installs exactly the packages of the lock file, and checks their digests.
digest=$(sha256sum <deploy/web/package-lock.json)
[ "$(cat "$out/installed" 2>/dev/null)" = "$digest" ] || {
  cp deploy/web/package.json deploy/web/package-lock.json "$out/"
  npm ci --prefix "$out" --ignore-scripts --no-audit --no-fund --loglevel=error
  echo "$digest" >"$out/installed"
}

protoc -I proto/third_party -I proto --plugin="$out/node_modules/.bin/protoc-gen-es" --es_out="$out/generated" \
  --es_opt=target=js+dts proto/lucerna/v1/*.proto proto/third_party/grpc/health/v1/health.proto

esbuild=(node_modules/.bin/esbuild --bundle --format=esm --preserve-symlinks --log-level=warning --legal-comments=none)
(
  cd "$out"
  "${esbuild[@]}" --platform=node --target=node18 source/gateway/main.js --outfile=lucerna-web.mjs
  "${esbuild[@]}" --minify --target=chrome110,firefox115,safari16.4 source/page/main.js --outfile=site/page.js
  cp source/page/index.html source/page/icon.svg site/
  cat source/page/style/*.css >site/page.css
  [ "${1:-}" != --check ] || node_modules/.bin/tsc --project source/tsconfig.json
)
