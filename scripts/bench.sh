#!/usr/bin/env bash
# Builds engram, runs all benchmarks and writes bench/RESULTS.md: bench.sh [ROUNDS], default 20.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

rounds=${1:-20}

# From rows budget.ID.OBS.PART to one line per task and observation.
budget_table() {
  awk 'NR > 1 {
         split($1, name, ".")
         key = "| " name[2] " | " name[3] " | "
         if (!(key in whole)) { keys[++count] = key; whole[key] = $(NF - 2) }
         if (count == 1) header = header " " name[4] " |"
         if (count == 1) rule = rule " ---: |"
         shares[key] = shares[key] sprintf(" %.1f |", 100 * $(NF - 1))
       }
       END {
         print "| task | observation | us |" header
         print "| --- | --- | ---: |" rule
         for (i = 1; i <= count; ++i) print keys[i] whole[keys[i]] " |" shares[keys[i]]
       }'
}

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
  for suite in overhead "overhead --num-envs 1" physics "physics --policy oracle" scaling memory objects reset create render; do
    echo
    echo "\`engram bench $suite\`"
    echo
    echo '```'
    # shellcheck disable=SC2086
    $engram bench $suite --rounds "$rounds"
    echo '```'
  done
  for policy in random oracle; do
    echo
    echo "\`engram bench budget --policy $policy\`: us per environment step and thread, and which percentage of"
    echo "it goes where. \`outside\` is everything but dynamics and render."
    echo
    $engram bench budget --policy "$policy" --rounds "$rounds" | budget_table
  done
} > bench/RESULTS.md.new
mv bench/RESULTS.md.new bench/RESULTS.md
