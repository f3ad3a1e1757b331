#!/usr/bin/env bash
# Builds the release preset and runs all tests, long ones included. Further arguments go to ctest,
# for instance -LE long. The last lines are ctest's summary.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release
exec ctest --preset release -j2 "$@"
