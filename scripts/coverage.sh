#!/usr/bin/env bash
# Measures how many lines the tests reach: coverage.sh [cpp|python...], default both. C++ by gcovr from a
# build with counters (preset coverage) and the quick tests; Python by coverage.py, with the engram
# that scripts/python_env.sh has installed. Prints one line for each folder and a total;
# docs/determinism.md has the figures of the last release.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cpp() {
  scripts/install_dependencies.sh gcovr
  scripts/build.sh coverage engram_tests engram_cli
  find build/coverage -name '*.gcda' -delete
  ctest --preset coverage -j2 -LE long --quiet || echo "some tests failed; lines are counted all the same" >&2
  local folder
  for folder in core mjcf tasks render media protocol api apps bench; do
    gcovr --root . --object-directory build/coverage --filter "$folder/" -j 2 --json-summary |
      python3 -c 'import json, sys
s = json.load(sys.stdin)
print(f"{sys.argv[1]:10} {s['"'line_covered'"']:6} of {s['"'line_total'"']:6} lines {s['"'line_percent'"']:5.1f} %")' \
        "$folder"
  done
}

python() {
  local env=build/python-env
  [ -x "$env/bin/python" ] || scripts/python_env.sh "$env"
  "$env/bin/uv" pip install --quiet --python "$env/bin/python" coverage
  COVERAGE_FILE=build/python-coverage "$env/bin/python" -m coverage run --source engram -m pytest -q \
    python --ignore python/tests/clients || echo "some tests failed; lines are counted all the same" >&2
  COVERAGE_FILE=build/python-coverage "$env/bin/python" -m coverage report --skip-covered | tail -n 1
}

[ $# -gt 0 ] || set -- cpp python
for part in "$@"; do
  case $part in
    cpp | python) "$part" ;;
    *)
      echo "coverage.sh: '$part' given; cpp and python allowed" >&2
      exit 2
      ;;
  esac
done
