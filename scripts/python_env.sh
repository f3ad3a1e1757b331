#!/usr/bin/env bash
# Builds the Python package and installs it into two virtual environments, with what its tests and
# examples need: python_env.sh [FOLDER], default build/python-env. FOLDER has the newest Gymnasium,
# torch, jax and Stable-Baselines3; FOLDER-0.29 has Gymnasium 0.29, which older stacks pin.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

env=${1:-build/python-env}
old=$env-0.29
tools=("scikit-build-core>=0.10" "nanobind>=2.4" pytest)

for folder in "$env" "$old"; do
  [ -x "$folder/bin/python" ] || python3 -m venv "$folder"
done
pip_install() {  # FOLDER REQUIREMENT...
  local folder=$1
  shift
  "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
}
pip_install "$env" "${tools[@]}" "gymnasium>=1.1" numpy torch jax stable-baselines3 matplotlib \
  array-api-compat moviepy vla-eval ruff mypy
pip_install "$old" "gymnasium==0.29.1" "numpy<2" pytest

# The compiler by the name that the main build calls it, so that ccache finds its objects again.
# Without precompiled headers: so every file of the library shows that it includes what it needs.
wheels=build/wheels
rm -rf "$wheels"
CC=${CC:-cc} CXX=${CXX:-c++} "$env/bin/python" -m pip wheel --quiet --disable-pip-version-check \
  --no-build-isolation --no-deps --wheel-dir "$wheels" \
  --config-settings=cmake.define.ENGRAM_PCH=OFF ./python
for folder in "$env" "$old"; do
  pip_install "$folder" --force-reinstall --no-deps "$wheels"/engram-*.whl
done
echo "engram is installed in $env and $old"
