#!/usr/bin/env bash
# Builds the Python package and installs it into virtual environments, with what its tests, clients
# and examples need: python_env.sh [--packages] [FOLDER], default build/python-env.
#   FOLDER       the newest of everything
#   FOLDER-0.29  Gymnasium 0.29 and NumPy 1, which older stacks pin, for smoke tests
#   FOLDER-data  readers of data sets: LeRobot, which needs Python 3.12 and an older torch, and
#                TensorFlow's, which whatever logs to TensorBoard would import at every start
# --packages installs what it needs alone, which can be done while the C++ is compiled.
# They share files: uv links what several of them install. Where no Python 3.12 or newer is installed,
# Debian 13's is built from its source package into build/python-3.13, in two or three minutes.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages_only=false
if [ "${1:-}" = --packages ]; then packages_only=true && shift; fi
env=${1:-build/python-env}
old=$env-0.29
data=$env-data

run_time=nanobind-backend  # of engram's own
readers=(pyarrow av pandas pillow protobuf google-crc32c h5py)  # data sets
shared=(
  "$run_time" pytest pytest-xdist numpy torch jax matplotlib array-api-compat moviepy "${readers[@]}"
  stable-baselines3 sb3-contrib torchrl skrl vla-eval
  mypy "pyright[nodejs]" pygame nbclient ipykernel
  statsmodels scipy  # what intervals and tests of results are checked against
  tyro tqdm rich colorama  # of the original's scripts, which engram.mikasa runs
  popgym==1.0.7  # tasks that memories of the learners are measured on
  aiohttp playwright websockets  # play, and what its tests talk to it with
  msgpack pyzmq json-numpy==2.1.1  # policy servers
)
# Partners of policy servers. They ask for NumPy 1, and work with 2.
partners=(openpi-client==0.1.2 openpi-server==0.1.0 policy-websocket==0.1.0)

works() {  # PYTHON: it runs, is new enough and can make virtual environments
  "$1" -c 'import sys, ensurepip, ssl, ctypes, lzma, bz2, sqlite3; sys.exit(sys.version_info < (3, 12))' \
    > /dev/null 2>&1
}

newer_python() {  # -> a Python 3.12 or newer, which LeRobot needs and Debian 12 does not have
  local python built=$PWD/build/python-3.13
  # pyenv's versions need not be on the search path.
  local pyenv=${PYENV_ROOT:-$HOME/.pyenv}/versions
  for python in python3.13 "$pyenv"/3.13.*/bin/python python3.12 "$pyenv"/3.12.*/bin/python; do
    if works "$python"; then
      "$python" -c 'import sys; print(sys.executable)'
      return
    fi
  done
  works "$built/bin/python3.13" || scripts/build_python.sh "$built" >&2
  works "$built/bin/python3.13" || { echo "the Python that was built does not work" >&2; exit 1; }
  echo "$built/bin/python3.13"
}

[ -x "$env/bin/python" ] || python3 -m venv "$env"
[ -x "$old/bin/python" ] || python3 -m venv "$old"
if [ ! -x "$data/bin/python" ]; then
  newer=$(newer_python)
  "$newer" -m venv "$data"
fi
"$env/bin/python" -m pip install --quiet --disable-pip-version-check --upgrade uv
install() {  # FOLDER REQUIREMENT...
  local folder=$1
  shift
  "$env/bin/uv" pip install --quiet --python "$folder/bin/python" "$@"
}
install "$env" "scikit-build-core>=0.10" "nanobind>=3.1" "gymnasium>=1.1" "${shared[@]}" ruff
install "$old" "gymnasium==0.29.1" "numpy<2" "$run_time" pytest pytest-xdist torch moviepy pygame
install "$env" --no-deps "${partners[@]}"
install "$data" "$run_time" "lerobot[dataset,evaluation]>=0.6.1" tensorflow-cpu \
  tensorflow-datasets pytest pytest-xdist "${readers[@]}"

if $packages_only; then exit; fi

# The compiler by the name that the main build calls it, precompiled headers and warnings as there, so
# that ccache finds its objects again. With ENGRAM_PCH=OFF they are all compiled, and every file of the
# library shows that it includes what it needs.
wheels=build/wheels
rm -rf "$wheels"
CC=${CC:-cc} CXX=${CXX:-c++} "$env/bin/python" -m pip wheel --quiet --disable-pip-version-check \
  --no-build-isolation --no-deps --wheel-dir "$wheels" \
  --config-settings=cmake.define.ENGRAM_WARNINGS_AS_ERRORS=ON \
  --config-settings=cmake.define.ENGRAM_PCH="${ENGRAM_PCH:-ON}" .
for folder in "$env" "$old" "$data"; do
  install "$folder" --no-deps --reinstall-package engram-sim "$wheels"/engram_sim-*.whl
done
install "$env" --no-deps --editable python/learners
echo "engram is installed in $env, $old and $data"
