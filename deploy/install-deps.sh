#!/usr/bin/env bash
# Installs the Debian 12 packages that are needed to build, test and run Lucerna, and nothing else.
# With names as arguments it installs just those packages, and with --runtime just the libraries
# that lucernad and lucerna load.  With --tests it also installs the programs that only tests use.
# Run it as root or with sudo.  It may be run twice: installed packages are skipped.
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache
  libgrpc++-dev protobuf-compiler-grpc libprotobuf-dev protobuf-compiler libabsl-dev libssl-dev zlib1g-dev
  libembree-dev libtbb-dev libopenimageio-dev openimageio-tools libopenexr-dev libpng-dev
  colord-data
  libcli11-dev libspdlog-dev libfmt-dev libtomlplusplus-dev libsystemd-dev libjemalloc-dev libboost-dev nlohmann-json3-dev libjs-chart.js
  libtinygltf-dev libdraco-dev libmeshoptimizer-dev
  prometheus-cpp-dev
  libgtest-dev libgmock-dev assimp-testmodels openssl
  python3 python3-grpcio python3-protobuf python3-gmpy2 python3-mpmath python3-numpy python3-pytest python3-yaml
)
# What tests use beside it, but for Blender.  tests/test_packages_test.py compares them with the tests.
tests=(
  bash-completion zsh fish man-db haproxy prometheus systemd npm
  mypy python3-matplotlib python3-pandas python3-pip python3-tqdm python3-venv
)
buf=@bufbuild/buf@1.75.0  # from npm
# tests/runtime_packages_test.py compares them with the programs.
runtime=(
  libgrpc++1.51 libprotobuf32 libabsl20220623 libssl3 zlib1g
  libembree3-3 libtbb12 libopenimageio2.4 libopenexr-3-1-30 libpng16-16
  libspdlog1.10 libfmt9 libtomlplusplus3 libsystemd0 libjemalloc2
  libdraco7 libmeshoptimizer2d libprometheus-cpp-pull1.0
)
if [ "${1:-}" = --runtime ]; then
  packages=("${runtime[@]}")
elif [ "${1:-}" = --tests ]; then
  packages+=("${tests[@]}")
elif [ $# -gt 0 ]; then
  packages=("$@")
fi

missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] && continue
  # Debian's npm and Node.js of another source exclude each other.
  [ "$package" = npm ] && command -v npm >/dev/null && continue
  missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  as_root=()
  [ "$(id -u)" = 0 ] || as_root=(sudo)
  export DEBIAN_FRONTEND=noninteractive
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" apt-get install -q -y --no-install-recommends "${missing[@]}"
fi

if [ "${1:-}" = --tests ]; then
  cd "$(dirname "$0")/.."
  [ "$(cat build/buf/installed 2>/dev/null)" = "$buf" ] || {
    npm install --prefix build/buf --no-save --no-audit --no-fund --loglevel=error "$buf"
    echo "$buf" >build/buf/installed
  }
fi
