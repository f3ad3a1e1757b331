#!/usr/bin/env bash
# Builds the documentation's site: docs_site.sh [--text] [FOLDER], default build/site; its first page
# is index.html. It needs no server and no network. Every warning is an error: dead links and anchors,
# pages in no list, functions of the headers that the reference leaves out.
#   --text   without the reference of the interfaces; needs no compiler, takes a minute
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

text_only=false
if [ "${1:-}" = --text ]; then text_only=true && shift; fi
site=${1:-build/site}
env=build/docs-env
work=build/docs

[ -x "$env/bin/python" ] || python3 -m venv "$env"
pip() { "$env/bin/python" -m pip --quiet --disable-pip-version-check "$@"; }
pip install --requirement docs/site/requirements.txt

# What the reference is made from: XML of the headers, and the Python package. Its compiled part comes
# out of a wheel, its docstrings from this tree.
wheel_in() { pip install --no-index --find-links "$1" --no-deps --force-reinstall engram-sim; }
read_interfaces() {
  scripts/install_dependencies.sh doxygen
  if ! wheel_in build/wheels 2>/dev/null; then
    CC=${CC:-cc} CXX=${CXX:-c++} pip wheel --no-deps --wheel-dir build/wheels .
    wheel_in build/wheels
  fi
  local packages
  packages=$("$env/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
  (cd python && find engram -name '*.py' -exec cp --parents -t "$packages" {} +)
  { cat docs/site/Doxyfile && echo "OUTPUT_DIRECTORY = $work/doxygen"; } | doxygen -
  export ENGRAM_DOXYGEN_XML=$PWD/$work/doxygen/xml
}

rm -rf "$site" "$work"
mkdir -p "$work"
$text_only || read_interfaces
"$env/bin/sphinx-build" --quiet --fail-on-warning --keep-going \
  --conf-dir docs/site --doctree-dir "$work/doctrees" docs "$site"
"$env/bin/python" docs/site/check_links.py "$site"
echo "the site is at $site/index.html"
