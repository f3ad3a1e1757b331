#!/usr/bin/env bash
# Builds with a sanitizer and runs the C++ tests under it: sanitize.sh asan|ubsan|tsan|asan-ubsan
# [ctest arguments], for instance -LE long. Any report fails the test that it comes from.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=${1:-}
case $preset in
  asan | ubsan | tsan | asan-ubsan) shift ;;
  *)
    echo "sanitize.sh: '$preset' given; asan, ubsan, tsan or asan-ubsan needed" >&2
    exit 2
    ;;
esac
# Clang builds these in half the time of GCC.
case $preset in
  asan-ubsan | tsan) scripts/install_dependencies.sh clang libclang-rt-dev ;;
esac
scripts/build.sh "$preset" engram_tests engram_cli engram_c_program engram_cross_entropy \
  engram_half_batches

suppressions=$PWD/scripts/suppressions
# Tests of failing allocations need an allocator that returns null.
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
export LSAN_OPTIONS=suppressions=$suppressions/lsan.txt:print_suppressions=0
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=suppressions=$suppressions/tsan.txt:second_deadlock_stack=1
ctest --preset "$preset" -j2 "$@"
