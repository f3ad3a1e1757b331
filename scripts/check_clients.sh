#!/usr/bin/env bash
# Tests engram with released packages that pin what the other clients have newer, each in a virtual
# environment of its own under build/clients: check_clients.sh [tianshou|rllib|pufferlib|sheeprl]...,
# default all.
# Needs what scripts/python_env.sh made: uv, and engram's wheel.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

declare -A packages=(
  [tianshou]="tianshou"
  [rllib]="ray[rllib] torch"
  [pufferlib]="pufferlib-core torch gymnasium>=1"
  [sheeprl]="sheeprl"
)
for name in "$@"; do
  if [ -z "${packages[$name]:-}" ]; then
    echo "unknown client '$name'; allowed: tianshou, rllib, pufferlib, sheeprl" >&2
    exit 2
  fi
done
if [ $# -eq 0 ]; then set -- tianshou rllib pufferlib sheeprl; fi
uv=build/python-env/bin/uv
[ -x $uv ] || scripts/python_env.sh

failed=()
for name in "$@"; do
  folder=build/clients/$name
  [ -x "$folder/bin/python" ] || python3 -m venv "$folder"
  # shellcheck disable=SC2086
  $uv pip install --quiet --python "$folder/bin/python" pytest ${packages[$name]}
  $uv pip uninstall --quiet --python "$folder/bin/python" engram  # its name before 0.5.0
  $uv pip install --quiet --python "$folder/bin/python" --reinstall-package engram-sim \
    build/wheels/engram_sim-*.whl
  "$folder/bin/python" -m pytest -rs --may-skip nothing "python/tests/clients/apart/test_$name.py" ||
    failed+=("$name")
done
if [ ${#failed[@]} -gt 0 ]; then
  printf 'failed: %s\n' "${failed[@]}" >&2
  exit 1
fi
