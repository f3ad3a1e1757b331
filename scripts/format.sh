#!/usr/bin/env bash
# Checks the formatting of all sources; with --fix, fixes it.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
  "") mode=(--dry-run --Werror) ;;
  --fix) mode=(-i) ;;
  *)
    echo "unknown argument '$1'; allowed: --fix" >&2
    exit 2
    ;;
esac
git ls-files -z --cached --others --exclude-standard -- '*.cc' '*.h' |
  while IFS= read -r -d '' file; do
    if [ -f "$file" ]; then printf '%s\0' "$file"; fi  # deleted files are still in the index
  done |
  xargs -0 -r clang-format "${mode[@]}"
