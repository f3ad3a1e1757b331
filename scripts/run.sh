#!/usr/bin/env bash
# Builds engram and runs it with the given arguments; without any, runs the main job.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/build.sh" release engram_cli >&2  # standard output belongs to the job

if [ $# -eq 0 ]; then
  set -- rollout RememberColor9-VLA-v0 --num-envs 256 --steps 200 --policy random
fi
exec "$root/build/release/engram" "$@"
