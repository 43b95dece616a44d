#!/usr/bin/env bash
# Installs what .ci/run needs: what `make test` needs, clang-format, chromium, checkers of packages; and from npm the
# checkers of Kubernetes manifests and of glTF files, and models and environments.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-deps.sh --tests
command -v clang-format >/dev/null || deploy/install-deps.sh clang-format
command -v chromium >/dev/null || deploy/install-deps.sh chromium
deploy/install-deps.sh lintian dpkg-dev file
tools=(@pmndrs/assets@1.7.0 gltf-validator@2.0.0-dev.3.10 kubernetes-models@4.5.1
  typescript@5.9.3 yaml@2.8.1)
[ "$(cat build/tools/installed 2>/dev/null)" = "${tools[*]}" ] || {
  # All at once: npm removes packages that its command does not name.
  npm install --prefix build/tools --no-save --no-audit --no-fund --loglevel=error "${tools[@]}"
  echo "${tools[*]}" >build/tools/installed
}
