#!/usr/bin/env bash
# Runs the checks of .pre-commit-config.yaml on all files: pre_commit.sh [ARGUMENT...], arguments go to
# `pre-commit run`. Files that are not as they should be are changed, and the exit code is 1.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

env=build/pre-commit-env
[ -x "$env/bin/pre-commit" ] || {
  python3 -m venv "$env"
  "$env/bin/python" -m pip install --quiet --disable-pip-version-check pre-commit
}
exec "$env/bin/pre-commit" run --all-files --show-diff-on-failure "$@"
