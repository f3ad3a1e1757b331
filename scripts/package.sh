#!/usr/bin/env bash
# Builds the Debian packages libengram0, libengram-dev, engram, engram-mpi and python3-engram into
# build/package/packages.
# BUILD_DIR names another build folder than build/package.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/install_dependencies.sh >&2
build=${BUILD_DIR:-build/package}
tools=build/package-env  # nanobind is not part of Debian
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check \
  --require-hashes --requirement scripts/release_tools.txt
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr -DENGRAM_HARDEN=ON \
  -DENGRAM_BUILD_TESTS=OFF -DENGRAM_BUILD_PYTHON=ON \
  -DPython_EXECUTABLE="$PWD/$tools/bin/python" >&2
cmake --build "$build" >&2
rm -rf "$build/packages"
(cd "$build" && cpack >&2)
for package in "$build"/packages/*.deb; do
  echo "$package"
done
