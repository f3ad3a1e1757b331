#!/usr/bin/env bash
# Builds the release preset and runs the tests: test.sh [OPTION...] [ctest argument...]
#   --long             also the tests labelled "long", which take minutes each; CI leaves them out. Each
#                      of them has a shorter form that always runs. The wheel is compiled without
#                      precompiled headers, which shows that every file includes what it needs.
#   --only PART        one part alone: cpp, style (ruff, mypy), python, data (readers of data sets), site
#   --changed [REV]    the tests alone that a change since REV can reach, which it lists; default: since
#                      this branch left main. tools/changed_tests.py --help says how they are chosen.
# ctest runs the tests of C++, pytest those of the Python package and its clients, in the virtual
# environments of scripts/python_env.sh; the documentation's site is built, which checks links and
# references. What waits or has one thread runs beside other parts. Everything runs even if something
# fails; the last lines say what was skipped and what failed, with its output. Clients that conflict
# with those of the newest environment have one to themselves: scripts/check_clients.sh.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

all=(cpp style site python data)
parts=("${all[@]}")
without_long=(-LE long)          # for ctest
without_long_python=(-m "not long")
changed=false since=()
while [ $# -gt 0 ]; do
  case $1 in
    --long)
      without_long=() without_long_python=()
      export ENGRAM_PCH=OFF  # of the wheel
      ;;
    --only)
      parts=("${2:-}")
      [[ " ${all[*]} " == *" ${parts[0]} "* ]] || { echo "--only ${2:-}: allowed: ${all[*]}" >&2; exit 2; }
      shift
      ;;
    --changed)
      changed=true
      if [ $# -gt 1 ]; then since=("$2") && shift; fi
      ;;
    *) break ;;
  esac
  shift
done
has() { [[ " ${parts[*]} " == *" $1 "* ]]; }

env=build/python-env
data=python/tests/clients/data  # what these run with has an environment of its own
apart=python/tests/clients/apart
# Hundreds of processes import torch, jax or NumPy, which takes half the time from bytecode.
unset PYTHONDONTWRITEBYTECODE
logs=build/logs
skipped=build/skipped.txt
failures=build/failures.txt  # what failed, and what it printed
failed=()
mkdir -p "$logs"
: > "$skipped"
: > "$failures"

python_tests() {  # ENVIRONMENT REASON-TO-SKIP ARGUMENT...
  local env=$1 may_skip=$2 log
  log=$(mktemp -p "$logs" pytest.XXXXXX)
  shift 2
  # A file's tests run in one process, because they share what it sets up.
  "$env/bin/python" -m pytest -n 2 --dist loadfile -rsfE --may-skip "$may_skip" \
    "${without_long_python[@]}" "$@" 2>&1 | tee "$log" ||
    failed+=("Python tests in $env")
  { grep '^SKIPPED' "$log" || echo nothing; } | sed "s|^|$env: |" >> "$skipped"
  grep -E '^(FAILED|ERROR) ' "$log" | sed "s|^|$env: |" >> "$failures" || true
}

declare -A running  # process ids of what runs beside others, by name
beside() {  # NAME COMMAND...
  local name=$1
  shift
  "$@" > "$logs/${name// /_}" 2>&1 &
  running[$name]=$!
}
await() {  # NAME...: waits for them, and prints what they printed
  local name
  for name in "$@"; do
    [ -n "${running[$name]:-}" ] || continue
    if ! wait "${running[$name]}"; then
      failed+=("$name")
      cat "$logs/${name// /_}" >> "$failures"
    fi
    cat "$logs/${name// /_}"
  done
}

report() {
  echo "skipped:"
  cat "$skipped"
  if [ ${#failed[@]} -gt 0 ]; then
    cat "$failures" >&2
    printf 'failed: %s\n' "${failed[@]}" >&2
    exit 1
  fi
}

cpp_tests() {
  scripts/build.sh release
  if ! ctest --preset release -j2 "${without_long[@]}" "$@" 2>&1 | tee build/ctest.log; then
    failed+=("C++ tests")
    awk '/^ *[0-9]+\/[0-9]+ Test / { shown = /\*\*\*/ } /^ +Start / { next } shown
         /^The following tests FAILED/ { shown = 1 }' build/ctest.log >> "$failures"
  fi
}

check_types() { (cd python && "../$env/bin/mypy" engram learners/src); }

smoke_tests() {  # with Gymnasium 0.29, which older stacks pin
  python_tests "$env-0.29" "Gymnasium 0.29" \
    python/tests/test_{autoreset,env,gym_registration,task_groups,vector_env}.py \
    python/tests/clients/test_gymnasium.py
  # In processes of its own: importing torch's compiler crashes where pygame has drawn before.
  python_tests "$env-0.29" "Gymnasium 0.29" -n 0 python/tests/clients/test_single_file_ppo.py
}

# The tests of a change, with sources of Python copied over the installed package.
changed_tests() {
  local chosen=build/changed_tests.txt file packages names=() conventions=() python=() readers=()
  python3 tools/changed_tests.py "${since[@]}" | tee "$chosen"
  while read -r kind file; do
    case $kind:$file in
      cpp:tests/conventions/*) conventions+=("$(basename "$file" .cc)") ;;
      cpp:*) names+=("$(basename "$file" .cc)") ;;
      python:"$apart"/*) ;;
      python:"$data"/*) readers+=("$file") ;;
      python:*) python+=("$file") ;;
    esac
  done < "$chosen"
  # Changes of Python or pages alone compile nothing where nothing has been compiled.
  if [ ${#names[@]} -gt 0 ] || [ -x build/release/engram_tests ]; then
    names+=("${conventions[@]}")
  fi
  if [ ${#names[@]} -gt 0 ]; then
    scripts/build.sh release engram_tests
    printf '[#%s]~[long]~[.]\n' "${names[@]}" | sort -u > "$logs/names"
    local half=$((($(wc -l < "$logs/names") + 1) / 2))
    beside "C++ tests, first half" build/release/engram_tests --filenames-as-tags \
      "$(head -n "$half" "$logs/names" | paste -sd,)"
    if [ "$(wc -l < "$logs/names")" -gt "$half" ]; then
      beside "C++ tests, second half" build/release/engram_tests --filenames-as-tags \
        "$(tail -n "+$((half + 1))" "$logs/names" | paste -sd,)"
    fi
    await "C++ tests, first half" "C++ tests, second half"
  fi
  if [ ${#python[@]} -eq 0 ] && [ ${#readers[@]} -eq 0 ]; then return; fi
  if [ ! -x "$env/bin/engram" ] || grep -q '^binding' "$chosen"; then scripts/python_env.sh "$env"; fi
  for file in "$env" "$env-data"; do
    packages=$("$file/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
    cp -a --remove-destination python/engram/. "$packages/engram/"  # uv's files are links
  done
  [ ${#python[@]} -eq 0 ] || python_tests "$env" "" "${python[@]}"
  [ ${#readers[@]} -eq 0 ] || python_tests "$env-data" "" "${readers[@]}"
}

if $changed; then
  changed_tests
  report
  exit
fi

scripts/install_dependencies.sh chromium doxygen  # of the browser's tests, and of the site
needs_env=false
for part in style python data site; do if has $part; then needs_env=true; fi; done
if $needs_env; then beside "packages" scripts/python_env.sh --packages "$env"; fi
if has cpp; then cpp_tests "$@"; fi
await "packages"
if $needs_env && ! scripts/python_env.sh "$env"; then
  failed+=("building the Python package")
  report
fi
if has style; then
  { "$env/bin/ruff" check . && "$env/bin/ruff" format --check .; } || failed+=("Python style")
  beside "types of the Python package" check_types
fi
if has site; then beside "the documentation's site" scripts/docs_site.sh; fi
if has python; then smoke_tests; fi
await "types of the Python package" "the documentation's site"
if has python; then python_tests "$env" nothing python --ignore "$data" --ignore "$apart"; fi
if has data; then python_tests "$env-data" nothing "$data"; fi
report
