#!/usr/bin/env bash
# Builds the release preset and runs all tests, long ones included: ctest for C++, then pytest for
# the Python package and its clients, in the virtual environments of scripts/python_env.sh; then
# builds the documentation's site, which checks links and references. Further arguments go to ctest,
# for instance -LE long. Everything runs even if something fails; the last lines are the summaries,
# and what was skipped. Clients that conflict with those of the newest environment have one to
# themselves: scripts/check_clients.sh.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release
failed=()
ctest --preset release -j2 "$@" || failed+=("C++ tests")

skipped=build/skipped.txt
: > "$skipped"
python_tests() {  # ENVIRONMENT REASON-TO-SKIP ARGUMENT...
  local env=$1 may_skip=$2 log=build/pytest.log
  shift 2
  "$env/bin/python" -m pytest -rs --may-skip "$may_skip" "$@" 2>&1 | tee "$log" ||
    failed+=("Python tests in $env")
  { grep '^SKIPPED' "$log" || echo nothing; } | sed "s|^|$env: |" >> "$skipped"
}
env=build/python-env
# What these run with has an environment of its own.
data=python/tests/clients/data
elsewhere=(--ignore "$data" --ignore python/tests/clients/apart)
if scripts/install_dependencies.sh chromium && scripts/python_env.sh "$env"; then  # for engram play
  "$env/bin/ruff" check python && "$env/bin/ruff" format --check python || failed+=("Python style")
  python_tests "$env-0.29" "Gymnasium 0.29" python "${elsewhere[@]}"
  python_tests "$env" nothing python "${elsewhere[@]}"
  python_tests "$env-data" nothing "$data"
  scripts/docs_site.sh || failed+=("the documentation's site")
else
  failed+=("building the Python package")
fi

echo "skipped:"
cat "$skipped"
if [ ${#failed[@]} -gt 0 ]; then
  printf 'failed: %s\n' "${failed[@]}" >&2
  exit 1
fi
