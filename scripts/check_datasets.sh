#!/usr/bin/env bash
# Runs python/tests/test_datasets.py with the real readers, in virtual environments under
# build/datasets: check_datasets.sh [tfds|lerobot]..., default both.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

declare -A readers=(
  [tfds]="tensorflow-cpu>=2.16 tensorflow-datasets>=4.9"
  [lerobot]="lerobot>=0.4,<0.5"
)
declare -A modules=([tfds]=tensorflow_datasets [lerobot]=lerobot.datasets.lerobot_dataset)
for name in "$@"; do
  if [ -z "${readers[$name]:-}" ]; then
    echo "unknown reader '$name'; allowed: tfds, lerobot" >&2
    exit 2
  fi
done
if [ $# -eq 0 ]; then set -- tfds lerobot; fi

scripts/build.sh release engram_cli
for name in "$@"; do
  folder=build/datasets/$name
  [ -x "$folder/bin/python" ] || python3 -m venv "$folder"
  # shellcheck disable=SC2086
  "$folder/bin/pip" install --quiet --disable-pip-version-check pytest ${readers[$name]}
  "$folder/bin/pip" install --quiet --disable-pip-version-check "./python[datasets]"
  ENGRAM_REQUIRE_READERS=${modules[$name]},engram._core,pyarrow,av,google_crc32c,pandas,PIL \
    HF_HUB_OFFLINE=1 "$folder/bin/python" -m pytest -q python/tests/test_datasets.py
done
