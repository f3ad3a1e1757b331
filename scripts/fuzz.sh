#!/usr/bin/env bash
# Fuzzes every parser of outside bytes and the plain C API: fuzz.sh [executions per target]
# [target...]. Installs Clang if it is missing, builds the targets (tests/fuzz) with sanitizers and
# runs each of them so many times, 1,000,000 unless said otherwise, from the corpus of the tests.
# What is found lies in build/fuzz/findings; a finding ends its target and this script fails.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

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
