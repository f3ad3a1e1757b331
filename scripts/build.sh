#!/usr/bin/env bash
# Installs what is missing, then configures and builds one preset: build.sh [PRESET], default release.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=${1:-release}
scripts/install_dependencies.sh
cmake --preset "$preset"
cmake --build --preset "$preset"
