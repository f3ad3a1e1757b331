#!/usr/bin/env bash
# Builds engram, checks that every task gives the same bits however it is run, and writes the table
# of docs/data/determinism.md: verify.sh [ID...], default all tasks (about 25 minutes on two cores).
# Fails, leaving the table as it was, if anything differs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release engram_cli >&2
engram=build/release/engram
page=docs/data/determinism.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

SECONDS=0
$engram verify "$@" > "$work/rows"
{
  sed '/^<!-- table -->$/q' "$page"
  echo
  echo "Written by \`scripts/verify.sh${*:+ $*}\` in $SECONDS s, on this machine:"
  echo
  echo '```'
  $engram doctor
  echo '```'
  echo
  echo "| task | env steps compared | different | state | rgb | objects |"
  echo "| --- | ---: | ---: | --- | --- | --- |"
  awk 'NR > 1 {
         if (!($1 in steps)) ids[++count] = $1
         gsub(",", "", $5); gsub(",", "", $6)
         steps[$1] += $5; different[$1] += $6; print_of[$1, $2] = $7
       }
       END {
         for (i = 1; i <= count; ++i) {
           id = ids[i]; all += steps[id]; wrong += different[id]
           printf "| %s | %d | %d | `%s` | `%s` | `%s` |\n", id, steps[id], different[id],
                  print_of[id, "state"], print_of[id, "rgb"], print_of[id, "objects"]
         }
         printf "| all %d | %d | %d | | | |\n", count, all, wrong
       }' "$work/rows"
} > "$work/page"
cp "$work/page" "$page"
