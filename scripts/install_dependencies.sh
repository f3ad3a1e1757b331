#!/usr/bin/env bash
# Installs the Debian packages that the build needs, and those that are named, such as clang; only
# those that are missing: install_dependencies.sh [PACKAGE...]
#   --list-libraries   prints what the Python package is built from instead
#   --mirror           prints the mirror of Debian that this machine's apt uses, or $MIRROR
set -euo pipefail

libraries=(
  libmujoco-dev libeigen3-dev libtinyxml2-dev librandom123-dev libpng-dev libzip-dev
  libegl-dev libgl-dev libcairo2-dev python3-dev
  libcli11-dev libfmt-dev nlohmann-json3-dev libxxhash-dev libboost-dev
)
case ${1:-} in
  --help | -h)  # without help.sh: the Containerfile takes this file alone
    sed -n '2,/^[^#]/ s/^# \{0,1\}//p' "$0"
    exit
    ;;
  --list-libraries)
    printf '%s\n' "${libraries[@]}"
    exit
    ;;
  --mirror)
    echo "${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | head -n 1)}"
    exit
    ;;
esac
packages=(
  build-essential cmake ninja-build ccache pkg-config
  "${libraries[@]}"
  libegl1 libegl-mesa0 libgl1-mesa-dri fonts-dejavu-core
  libavcodec-dev libavformat-dev libavutil-dev libswscale-dev
  python3-venv
  libopenmpi-dev openmpi-bin
  catch2
  "$@"
)

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  exit 0
fi

if [ "$(id -u)" -eq 0 ]; then
  as_root=()
elif command -v sudo >/dev/null; then
  as_root=(sudo)
else
  echo "missing packages: ${missing[*]}; installing them needs root or sudo" >&2
  exit 1
fi
apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y "$@"; }

# The package lists are fetched only where those at hand do not lead to an installation.
install=(install --no-install-recommends "${missing[@]}")
apt "${install[@]}" || { apt update && apt "${install[@]}"; }
