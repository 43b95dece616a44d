#!/usr/bin/env bash
# Installs what only .ci/run needs: clang-format, prometheus, shells, checkers of packages and what the tests of the
# Python package check with, and from npm buf, the checkers of Kubernetes manifests and of glTF files, and models and
# environments.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-deps.sh
command -v clang-format >/dev/null || deploy/install-deps.sh clang-format
command -v prometheus >/dev/null || deploy/install-deps.sh prometheus
deploy/install-deps.sh mypy python3-matplotlib python3-pandas python3-pip python3-tqdm python3-venv
command -v npm >/dev/null || deploy/install-deps.sh npm
# Shells whose completion is tested, and what checks manual pages and packages.
deploy/install-deps.sh bash-completion zsh fish man-db lintian dpkg-dev file
tools=(@bufbuild/buf@1.75.0 @pmndrs/assets@1.7.0 gltf-validator@2.0.0-dev.3.10 kubernetes-models@4.5.1
  typescript@5.9.3 yaml@2.8.1)
[ "$(cat build/tools/installed 2>/dev/null)" = "${tools[*]}" ] || {
  # All at once: npm removes packages that its command does not name.
  npm install --prefix build/tools --no-save --no-audit --no-fund --loglevel=error "${tools[@]}"
  echo "${tools[*]}" >build/tools/installed
}
