#!/usr/bin/env bash
# Builds the release preset and runs the tests: test.sh [--long] [ctest argument...]
#   --long   also the tests labelled "long", which take minutes each; CI leaves them out. Each of
#            them has a shorter form that always runs. The wheel is compiled without precompiled
#            headers, which shows that every file includes what it needs.
# ctest runs those of C++, then pytest those of the Python package and its clients, in the virtual
# environments of scripts/python_env.sh; then the documentation's site is built, which checks links
# and references. Everything runs even if something fails; the last lines say what was skipped and
# what failed, with its output. Clients that conflict with those of the newest environment have one
# to themselves: scripts/check_clients.sh.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

without_long=(-LE long)          # for ctest
without_long_python=(-m "not long")
case ${1:-} in
  --long)
    without_long=() without_long_python=()
    export ENGRAM_PCH=OFF  # of the wheel
    shift
    ;;
esac

scripts/build.sh release
failed=()
skipped=build/skipped.txt
failures=build/failures.txt  # what failed, and what it printed
: > "$skipped"
: > "$failures"
if ! ctest --preset release -j2 "${without_long[@]}" "$@" 2>&1 | tee build/ctest.log; then
  failed+=("C++ tests")
  awk '/^ *[0-9]+\/[0-9]+ Test / { shown = /\*\*\*/ } /^ +Start / { next } shown
       /^The following tests FAILED/ { shown = 1 }' build/ctest.log >> "$failures"
fi

python_tests() {  # ENVIRONMENT REASON-TO-SKIP ARGUMENT...
  local env=$1 may_skip=$2 log=build/pytest.log
  shift 2
  # A file's tests run in one process, because they share what it sets up.
  "$env/bin/python" -m pytest -n 2 --dist loadfile -rsfE --may-skip "$may_skip" \
    "${without_long_python[@]}" "$@" 2>&1 | tee "$log" ||
    failed+=("Python tests in $env")
  { grep '^SKIPPED' "$log" || echo nothing; } | sed "s|^|$env: |" >> "$skipped"
  grep -E '^(FAILED|ERROR) ' "$log" | sed "s|^|$env: |" >> "$failures" || true
}
env=build/python-env
# What these run with has an environment of its own.
data=python/tests/clients/data
elsewhere=(--ignore "$data" --ignore python/tests/clients/apart)
# The smoke tests of Gymnasium 0.29, which older stacks pin.
smoke=(python/tests/test_{autoreset,env,gym_registration,task_groups,vector_env}.py
  python/tests/clients/test_gymnasium.py)
if scripts/install_dependencies.sh chromium && scripts/python_env.sh "$env"; then  # for engram play
  "$env/bin/ruff" check . && "$env/bin/ruff" format --check . || failed+=("Python style")
  (cd python && "../$env/bin/mypy" engram learners/src) || failed+=("types of the Python package")
  python_tests "$env-0.29" "Gymnasium 0.29" "${smoke[@]}"
  # In processes of its own: importing torch's compiler crashes where pygame has drawn before.
  python_tests "$env-0.29" "Gymnasium 0.29" python/tests/clients/test_single_file_ppo.py
  python_tests "$env" nothing python "${elsewhere[@]}"
  python_tests "$env-data" nothing "$data"
  scripts/docs_site.sh || failed+=("the documentation's site")
else
  failed+=("building the Python package")
fi

echo "skipped:"
cat "$skipped"
if [ ${#failed[@]} -gt 0 ]; then
  cat "$failures" >&2
  printf 'failed: %s\n' "${failed[@]}" >&2
  exit 1
fi
