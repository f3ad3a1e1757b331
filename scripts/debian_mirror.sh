#!/usr/bin/env bash
# Prints the mirror of Debian that this machine's apt uses, or $MIRROR.
set -euo pipefail
echo "${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | head -n 1)}"
