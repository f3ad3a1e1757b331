#!/usr/bin/env bash
# Builds Debian 13's Python, from where this machine has its packages: build_python.sh PREFIX
# [CONFIGURE-OPTION...]. It takes two or three minutes, and changes nothing of apt's own.
#   build_python.sh build/python-3.13
#   build_python.sh build/python-3.13t --disable-gil
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

prefix=$(realpath -m "${1:?PREFIX needed}")
shift
scripts/install_dependencies.sh libssl-dev libffi-dev zlib1g-dev libbz2-dev liblzma-dev libsqlite3-dev
keys=/usr/share/keyrings/debian-archive-keyring.gpg
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
mkdir -p "$work"/{lists/partial,cache/archives/partial,source}
echo "deb-src [signed-by=$keys] $(scripts/install_dependencies.sh --mirror) trixie main" \
  > "$work/sources.list"
apt=(apt-get -qq -o "Dir::Etc::SourceList=$work/sources.list" -o Dir::Etc::SourceParts=/dev/null
  -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache")
"${apt[@]}" update
cd "$work/source"
"${apt[@]}" source --download-only python3.13
tar -xf python3.13_*.orig.tar.xz --strip-components=1
./configure --quiet --prefix="$prefix" --disable-test-modules "$@"
make -s -j2
make -s install
