#!/usr/bin/env bash
# Builds the release preset and runs all tests, long ones included: ctest for C++, then pytest for
# the Python package, with two versions of Gymnasium. Further arguments go to ctest, for instance
# -LE long. Everything runs even if something fails; the last lines are the summaries.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release
failed=()
ctest --preset release -j2 "$@" || failed+=("C++ tests")
if scripts/python_env.sh; then
  for env in build/python-env-0.29 build/python-env; do
    "$env/bin/python" -m pytest python || failed+=("Python tests in $env")
  done
  build/python-env/bin/ruff check python && build/python-env/bin/ruff format --check python ||
    failed+=("Python style")
else
  failed+=("building the Python package")
fi
if [ ${#failed[@]} -gt 0 ]; then
  printf 'failed: %s\n' "${failed[@]}" >&2
  exit 1
fi
