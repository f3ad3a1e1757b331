#!/usr/bin/env bash
# Checks that `engram eval` gives the same bytes for threads 1 and 2, batches of 1, 8 and 64, and
# ranks 1, 2 and 3: check_evaluation.sh [EVAL ARGUMENTS...], default two tasks of each split with
# images. ENGRAM names the command, default build/release/engram.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

engram=${ENGRAM:-build/release/engram}
if [ $# -eq 0 ]; then
  set -- RememberColor3-VLA-v0 TakeItBack-VLA-v0 ShellGameShuffleTouch-VLA-v0 BunchOfColors3-VLA-v0 \
    SeqOfColors7-VLA-v0 BatteriesCheckerEasy-6-VLA-v0 --episodes 9 --obs rgb --policy oracle
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

failures=0
compare() { # LABEL COMMAND...
  local label=$1
  shift
  "$@" eval "${arguments[@]}" --json > "$folder/now.json"
  [ -e "$folder/first.json" ] || cp "$folder/now.json" "$folder/first.json"
  if cmp -s "$folder/first.json" "$folder/now.json"; then
    echo "same       $label"
  else
    echo "DIFFERENT  $label"
    failures=$((failures + 1))
  fi
}

for threads in 1 2; do
  for num_envs in 1 8 64; do
    arguments=("$@" --threads "$threads" --num-envs "$num_envs")
    compare "threads $threads, num-envs $num_envs" "$engram"
  done
done
if command -v mpirun > /dev/null; then
  for ranks in 1 2 3; do
    arguments=("$@")
    compare "ranks $ranks" mpirun --oversubscribe -n "$ranks" "$engram"
  done
else
  echo "no mpirun here: ranks not checked"
fi
sha256sum "$folder/first.json" | cut -d' ' -f1
exit $((failures > 0))
