#!/usr/bin/env bash
# Runs clang-tidy: tidy.sh [FILE...], default every source file that the build compiles.
# BUILD_DIR names the build folder, default build/release; JOBS the number of processes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=${BUILD_DIR:-build/release}
if [ ! -f "$build/compile_commands.json" ]; then
  cmake --preset release >&2
fi
if [ $# -eq 0 ]; then
  mapfile -t files < <(sed -n 's/^ *"file": "\(.*\)",*$/\1/p' "$build/compile_commands.json")
  set -- "${files[@]}"
fi
printf '%s\0' "$@" | xargs -0 -r -n 1 -P "${JOBS:-2}" clang-tidy --quiet -p "$build"
