#!/usr/bin/env bash
# Installs what is missing, then configures and builds: build.sh [PRESET [TARGET...]], default
# everything of release.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=${1:-release}
scripts/install_dependencies.sh
cmake --preset "$preset"
shift $(($# > 0 ? 1 : 0))
cmake --build --preset "$preset" ${1:+--target "$@"}
