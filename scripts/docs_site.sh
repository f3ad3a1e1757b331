#!/usr/bin/env bash
# Builds the documentation's site: docs_site.sh [FOLDER], default build/site; its first page is
# index.html. It needs no server and no network. Every warning is an error: dead links and anchors,
# pages in no list, functions of the headers that the reference leaves out.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

site=${1:-build/site}
env=build/docs-env
work=build/docs

scripts/install_dependencies.sh doxygen
[ -x "$env/bin/python" ] || python3 -m venv "$env"
pip() { "$env/bin/python" -m pip --quiet --disable-pip-version-check "$@"; }
pip install --requirement docs/site/requirements.txt

# The package's compiled part comes out of a wheel, its docstrings from this tree.
wheel_in() { pip install --no-index --find-links "$1" --no-deps --force-reinstall engram-sim; }
if ! wheel_in build/wheels 2>/dev/null; then
  CC=${CC:-cc} CXX=${CXX:-c++} pip wheel --no-deps --wheel-dir build/wheels .
  wheel_in build/wheels
fi
packages=$("$env/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
(cd python && find engram -name '*.py' -exec cp --parents -t "$packages" {} +)

rm -rf "$site" "$work"
mkdir -p "$work"
{ cat docs/site/Doxyfile && echo "OUTPUT_DIRECTORY = $work/doxygen"; } | doxygen -
ENGRAM_DOXYGEN_XML=$PWD/$work/doxygen/xml "$env/bin/sphinx-build" --quiet --fail-on-warning \
  --keep-going --conf-dir docs/site --doctree-dir "$work/doctrees" docs "$site"
"$env/bin/python" docs/site/check_links.py "$site"
echo "the site is at $site/index.html"
