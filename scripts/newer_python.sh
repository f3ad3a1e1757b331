#!/usr/bin/env bash
# Prints the path of a Python 3.12 or newer, which LeRobot needs and Debian 12 does not have: one
# that is installed, or else Debian 13's, built from its source package into build/python-3.13
# (about three minutes on two cores). newer_python.sh --build does not look for an installed one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

built=$PWD/build/python-3.13

works() {  # PYTHON: it runs, is new enough and can make virtual environments
  "$1" -c 'import sys, ensurepip, ssl, ctypes, lzma, bz2, sqlite3; sys.exit(sys.version_info < (3, 12))' \
    > /dev/null 2>&1
}

if [ "${1:-}" != --build ]; then
  # pyenv's versions need not be on the search path.
  pyenv=${PYENV_ROOT:-$HOME/.pyenv}/versions
  for python in python3.13 "$pyenv"/3.13.*/bin/python python3.12 "$pyenv"/3.12.*/bin/python; do
    if works "$python"; then
      "$python" -c 'import sys; print(sys.executable)'
      exit
    fi
  done
fi
if works "$built/bin/python3.13"; then
  echo "$built/bin/python3.13"
  exit
fi

echo "building Python 3.13" >&2
{
  scripts/install_dependencies.sh libssl-dev libffi-dev zlib1g-dev libbz2-dev liblzma-dev \
    libsqlite3-dev
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  chmod 755 "$work"
  mkdir -p "$work"/{lists/partial,cache/archives/partial,source}
  # Debian 13's sources, from where this machine has its packages; nothing of apt's own is changed.
  mirror=$(scripts/debian_mirror.sh)
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  echo "deb-src [signed-by=$keys] $mirror trixie main" > "$work/sources.list"
  apt=(apt-get -qq -o "Dir::Etc::SourceList=$work/sources.list" -o Dir::Etc::SourceParts=/dev/null
    -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache")
  "${apt[@]}" update
  (cd "$work/source" && "${apt[@]}" source --download-only python3.13)
  tar -xf "$work"/source/python3.13_*.orig.tar.xz -C "$work/source" --strip-components=1
  cd "$work/source"
  ./configure --quiet --prefix="$built" --disable-test-modules
  make -s -j2
  make -s install
} >&2
works "$built/bin/python3.13" || { echo "the Python that was built does not work" >&2; exit 1; }
echo "$built/bin/python3.13"
