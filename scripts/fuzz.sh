#!/usr/bin/env bash
# Fuzzes every parser of outside bytes and the C API, or the Python side. Fails if there are findings.
#   fuzz.sh [EXECUTIONS [TARGET...]]  builds the targets (tests/fuzz) with Clang and sanitizers, and runs
#                                     each from the corpus of the tests, default 1,000,000 times;
#                                     findings lie in build/fuzz/findings, and end their target
#   fuzz.sh python [CASES [FIRST]]    plays generated data sets, arguments and messages, default
#                                     10,000 cases of each, from case FIRST on. $PYTHON has engram,
#                                     default build/python-env's; without the libraries of the extra
#                                     `datasets`, data sets are read, not converted
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [ "${1:-}" = python ]; then
  python=${PYTHON:-build/python-env/bin/python}
  failed=0
  for search in fuzz_datasets fuzz_options servers/fuzz_codecs; do
    "$python" -W ignore "python/tests/$search.py" "${2:-10000}" "${3:-0}" || failed=1
  done
  exit $failed
fi

executions=${1:-1000000}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] ||
  targets=(command_line policy_pipe npz results edits demonstrations snapshot c_api)

scripts/install_dependencies.sh clang libclang-rt-dev
cmake --preset fuzz
cmake --build --preset fuzz --target "${targets[@]/#/fuzz_}"

# ASan's allocator returns null where memory is exhausted, as the library expects. Short stacks and
# a small quarantine of freed memory save time.
export ASAN_OPTIONS=allocator_may_return_null=1:malloc_context_size=3:quarantine_size_mb=8
# Files that targets write are flushed, which takes no time in memory.
[ ! -d /dev/shm ] || export TMPDIR=/dev/shm
mkdir -p build/fuzz/findings

fuzz() {
  local target=$1 corpus=build/fuzz/corpus/$1 log=build/fuzz/$1.log failed=0
  mkdir -p "$corpus"
  "build/fuzz/fuzz_$target" "$corpus" \
    "tests/data/fuzz/$target" -runs="$executions" -max_len=1024 -timeout=20 -rss_limit_mb=4096 \
    -artifact_prefix="build/fuzz/findings/$target-" -print_final_stats=1 >"$log" 2>&1 || failed=1
  echo "$target, log in $log:"
  grep -E "DONE|number_of_executed_units|average_exec_per_sec|ERROR|SUMMARY" "$log" || true
  return $failed
}
export -f fuzz
export executions
echo "$executions executions of each: ${targets[*]}"
# As many of them at once as there are cores.
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I '{}' bash -euc 'fuzz {}' || {
  echo "there are findings: see above" >&2
  exit 1
}
