#!/usr/bin/env bash
# Runs the checks of .pre-commit-config.yaml on all files: pre_commit.sh [ARGUMENT...], arguments go to
# `pre-commit run`. Files that are not as they should be are changed, and the exit code is 1.
#   --install   runs them at every commit from now on, with the check of the commit's subject
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

env=build/pre-commit-env
[ -x "$env/bin/pre-commit" ] || {
  python3 -m venv "$env"
  "$env/bin/python" -m pip install --quiet --disable-pip-version-check pre-commit
}
if [ "${1:-}" = --install ]; then exec "$env/bin/pre-commit" install; fi
exec "$env/bin/pre-commit" run --all-files --show-diff-on-failure "$@"
