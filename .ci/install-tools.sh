#!/usr/bin/env bash
# Tools that check the sources and that no build or run needs: clang-format, and buf from npm.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-deps.sh
command -v clang-format >/dev/null || deploy/install-deps.sh clang-format
command -v npm >/dev/null || deploy/install-deps.sh npm
[ -x build/tools/node_modules/.bin/buf ] ||
  npm install --prefix build/tools --no-save --no-audit --no-fund --loglevel=error @bufbuild/buf@1.75.0
