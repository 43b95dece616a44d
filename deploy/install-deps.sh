#!/usr/bin/env bash
# Installs the Debian 12 packages that are needed to build, test and run Lucerna, and nothing else.
# With names as arguments it installs just those packages, and with --runtime just the libraries
# that lucernad and lucerna load.  Run it as root or with sudo.  It may be run twice: installed
# packages are skipped.
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache
  libgrpc++-dev protobuf-compiler-grpc libprotobuf-dev protobuf-compiler libabsl-dev libssl-dev zlib1g-dev
  libembree-dev libtbb-dev libopenimageio-dev openimageio-tools libopenexr-dev libpng-dev
  colord-data
  libcli11-dev libspdlog-dev libfmt-dev libtomlplusplus-dev libsystemd-dev libjemalloc-dev libboost-dev nlohmann-json3-dev libjs-chart.js
  libtinygltf-dev libdraco-dev libmeshoptimizer-dev
  prometheus-cpp-dev
  libgtest-dev libgmock-dev libbenchmark-dev assimp-testmodels openssl
  python3 python3-grpcio python3-protobuf python3-gmpy2 python3-mpmath python3-numpy python3-pytest python3-yaml
)
# tests/runtime_packages_test.py compares them with the programs.
runtime=(
  libgrpc++1.51 libprotobuf32 libabsl20220623 libssl3 zlib1g
  libembree3-3 libtbb12 libopenimageio2.4 libopenexr-3-1-30 libpng16-16
  libspdlog1.10 libfmt9 libtomlplusplus3 libsystemd0 libjemalloc2
  libdraco7 libmeshoptimizer2d libprometheus-cpp-pull1.0
)
if [ "${1:-}" = --runtime ]; then
  packages=("${runtime[@]}")
elif [ $# -gt 0 ]; then
  packages=("$@")
fi

missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
[ "$(id -u)" = 0 ] || as_root=(sudo)
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -q
"${as_root[@]}" apt-get install -q -y --no-install-recommends "${missing[@]}"
