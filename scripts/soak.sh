#!/usr/bin/env bash
# Builds engram and runs it for long over all tasks, watching for growth, drift and instability:
# soak.sh [ENV_STEPS [CYCLES]], default 10 million environment steps and 10 thousand batches. Fails
# if a bound is broken.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release engram_cli >&2
exec build/release/engram soak --env-steps "${1:-10000000}" --cycles "${2:-10000}"
