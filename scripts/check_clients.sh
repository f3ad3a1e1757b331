#!/usr/bin/env bash
# Tests engram with released packages that pin what the other clients have newer, each in a virtual
# environment of its own under build/clients:
# check_clients.sh [tianshou|ray|rllib|pufferlib|sheeprl|lerobot_v21|robomimic|linters|inspect_robots|openenv|memories]..., default all.
# "memories" holds the memories of the learners against their released implementations.
# Needs what scripts/python_env.sh made: uv, and engram's wheel.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

declare -A packages=(
  [tianshou]="tianshou"
  [ray]="ray"
  [rllib]="ray[rllib] torch"
  [pufferlib]="pufferlib-core torch gymnasium>=1"
  [sheeprl]="sheeprl"
  [memories]="torch mingru-pytorch==0.2.1 mambapy==1.2.0 xlstm==2.0.6 s5-pytorch==0.2.1
    x-transformers==2.31.10"
  [linters]="lerobot-doctor==0.2.0 deepen-grade[lerobot]==0.4.1 protobuf google-crc32c pillow"
  [inspect_robots]="inspect-robots==0.60.0"
  [openenv]="openenv==0.10.0"
  # What the reader of data sets needs of the last LeRobot for version 2.1, whose own list is long.
  [lerobot_v21]="torch==2.7.1 torchvision==0.22.1 datasets==3.6.0 huggingface-hub==0.36.2 av==15.1.0
    jsonlines==4.0.0 numpy==2.2.6 packaging pandas pillow protobuf pyarrow google-crc32c"
  # Likewise; robomimic also asks for egl_probe, which has to be compiled.
  [robomimic]="torch torchvision h5py psutil tqdm termcolor tensorboardX imageio matplotlib six"
)
declare -A without_dependencies=([lerobot_v21]="lerobot==0.3.3" [robomimic]="robomimic==0.3.0")
names=(tianshou ray rllib pufferlib sheeprl lerobot_v21 robomimic linters inspect_robots openenv memories)
for name in "$@"; do
  if [ -z "${packages[$name]:-}" ]; then
    echo "unknown client '$name'; allowed: ${names[*]}" >&2
    exit 2
  fi
done
if [ $# -eq 0 ]; then set -- "${names[@]}"; fi
uv=build/python-env/bin/uv
[ -x $uv ] || scripts/python_env.sh

failed=()
for name in "$@"; do
  folder=build/clients/$name
  [ -x "$folder/bin/python" ] || python3 -m venv "$folder"
  # shellcheck disable=SC2086
  $uv pip install --quiet --python "$folder/bin/python" pytest ${packages[$name]}
  if [ -n "${without_dependencies[$name]:-}" ]; then
    $uv pip install --quiet --python "$folder/bin/python" --no-deps "${without_dependencies[$name]}"
  fi
  $uv pip install --quiet --python "$folder/bin/python" --reinstall-package engram-sim \
    build/wheels/engram_sim-*.whl
  "$folder/bin/python" -m pytest -rs --may-skip nothing "python/tests/clients/apart/test_$name.py" ||
    failed+=("$name")
done
if [ ${#failed[@]} -gt 0 ]; then
  printf 'failed: %s\n' "${failed[@]}" >&2
  exit 1
fi
