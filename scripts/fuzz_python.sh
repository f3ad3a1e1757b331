#!/usr/bin/env bash
# Plays made-up data sets and made-up arguments of the Python API: fuzz_python.sh [cases of each,
# 10,000 unless said otherwise [number of the first]]. $PYTHON is an interpreter with engram
# installed, build/python-env's by default; without the libraries of the extra `datasets`, data sets
# are read, not converted. Ends with what was refused and accepted; fails if there are findings, each of
# which names the case that shows it again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-build/python-env/bin/python}
failed=0
for search in fuzz_datasets fuzz_options; do
  "$python" -W ignore "python/tests/$search.py" "${1:-10000}" "${2:-0}" || failed=1
done
exit $failed
