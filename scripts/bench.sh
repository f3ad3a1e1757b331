#!/usr/bin/env bash
# Builds engram, runs all benchmarks and writes bench/RESULTS.md: bench.sh [ROUNDS], default 20.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

rounds=${1:-20}
scripts/build.sh release engram_cli >&2
engram=build/release/engram
{
  echo "# Results"
  echo
  echo "Written by \`scripts/bench.sh $rounds\`. Each suite runs interleaved with its baseline in one"
  echo "process; values are medians over $rounds rounds, ratios are medians of the rounds' ratios."
  echo
  echo '```'
  $engram doctor
  echo '```'
  for suite in all "physics --policy oracle"; do
    echo
    echo "\`engram bench $suite\`"
    echo
    echo '```'
    # shellcheck disable=SC2086
    $engram bench $suite --rounds "$rounds"
    echo '```'
  done
} > bench/RESULTS.md.new
mv bench/RESULTS.md.new bench/RESULTS.md
