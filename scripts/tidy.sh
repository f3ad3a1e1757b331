#!/usr/bin/env bash
# Runs clang-tidy: tidy.sh [FILE...], default every source file that the build compiles. It reads them
# without precompiled headers (preset tidy), so it also finds files that do not include what they use.
# BUILD_DIR names the build folder, default build/tidy; JOBS the number of processes.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=${BUILD_DIR:-build/tidy}
if [ -z "${BUILD_DIR:-}" ]; then
  cmake --preset tidy >/dev/null  # again each time: files come and go
fi
if [ $# -eq 0 ]; then
  mapfile -t files < <(sed -n 's/^ *"file": "\(.*\)",*$/\1/p' "$build/compile_commands.json")
  set -- "${files[@]}"
fi
printf '%s\0' "$@" | xargs -0 -r -n 1 -P "${JOBS:-2}" clang-tidy --quiet -p "$build"
