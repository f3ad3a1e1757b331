#!/usr/bin/env bash
# Builds what pip installs without a compiler: wheel.sh [KIND...], into build/dist (or $DIST).
#   native    the wheel for this machine's processor (the default)
#   aarch64   the one for 64-bit ARM, with Debian's cross-compiler and arm64 packages; after native
#   free-threaded  the one for a Python without a global lock, $PYTHON; default: 3.13, built from source
#   sdist     the sources, from which pip builds where the packages of install_dependencies.sh are
# libmujoco and what else the extension links to travel inside. One wheel serves all versions of
# CPython from 3.10 on, and systems from glibc 2.34 on: docs/packaging.md says why.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

dist=${DIST:-build/dist}
tools=build/wheel-env
plain=build/wheels-plain
sysroot=${SYSROOT:-$PWD/build/sysroot-aarch64}
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check \
  --require-hashes --requirement scripts/release_tools.txt
export PATH="$PWD/$tools/bin:$PATH"
mkdir -p "$dist"

build() {  # CMAKE_DEFINITION... -> the only wheel in $plain
  local settings=()
  for definition in "$@"; do settings+=("--config-settings=cmake.define.$definition"); done
  rm -rf "$plain"
  # Compilers by the names that the main build calls them, so that ccache finds its objects again.
  CC=${CC:-cc} CXX=${CXX:-c++} "${builder:-python}" -m pip wheel --quiet --disable-pip-version-check \
    --no-build-isolation --no-deps --wheel-dir "$plain" "${settings[@]}" \
    --config-settings=cmake.define.ENGRAM_PCH=OFF \
    --config-settings=cmake.define.ENGRAM_WARNINGS_AS_ERRORS=ON \
    --config-settings=cmake.define.ENGRAM_HARDEN=ON \
    --config-settings=cmake.define.ENGRAM_WHEEL=ON .
}

# Takes libraries into the wheel, and names the oldest system that all of it runs on.
finish() {  # GLIBC MACHINE
  # auditwheel takes the names of its own machine's platforms only, though it knows all.
  python -c "import platform, sys; platform.machine = lambda: '$2'
from auditwheel.main import main
sys.exit(main())" repair --plat "manylinux_$1_$2" --wheel-dir "$dist" "$plain"/engram_sim-*.whl
  local made
  made=$(newest "manylinux_$1_$2")
  if [[ $made == *-abi3-* ]]; then abi3audit --strict --summary "$made"; fi
  check_hardened "$made"
}

newest() {  # PLATFORM -> the wheel; earlier versions may lie beside it
  find "$dist" -name "engram_sim-*$1.whl" -printf '%T@ %p\n' | sort -n | tail -n 1 | cut -d ' ' -f 2-
}

# What is compiled here protects its stacks, checks copies and binds its symbols at the start.
check_hardened() {  # WHEEL
  local work file symbols
  work=$(mktemp -d)
  python -m zipfile -e "$1" "$work"
  for file in "$work"/engram/_core*.so "$work"/engram/command/engram; do
    symbols=$(readelf --wide --dyn-syms "$file")
    if ! { readelf --dynamic "$file" | grep -q 'BIND_NOW\|Flags:.*NOW'; } ||
      ! { grep -q __stack_chk_fail <<<"$symbols" && grep -q '__[a-z]*_chk@' <<<"$symbols"; }; then
      echo "wheel.sh: ${file#"$work"/} of $1 is not hardened" >&2
      exit 1
    fi
  done
  rm -rf "$work"
}

native() {
  scripts/install_dependencies.sh
  build
  if [ "$(uname -m)" = aarch64 ]; then libccd cc; fi
  AUDITWHEEL_LD_LIBRARY_PATH=${ccd:-} finish 2_34 "$(uname -m)"
}

# nanobind-backend has no wheels for 3.13t and 3.14t, which have no stable ABI: the extension has it
# inside. From 3.15t on the usual way serves, for all versions.
free_threaded() {
  scripts/install_dependencies.sh
  local builder=$PWD/build/python-3.13t/bin/python3
  if [ -n "${PYTHON:-}" ]; then
    builder=$(command -v "$PYTHON")
  elif [ ! -x "$builder" ]; then
    scripts/build_python.sh "${builder%/bin/*}" --disable-gil
  fi
  if ! "$builder" -c 'import sys, sysconfig
sys.exit(not sysconfig.get_config_var("Py_GIL_DISABLED") or sys.version_info >= (3, 15))'; then
    echo "wheel.sh: PYTHON=$builder given; a free-threaded 3.13 or 3.14 needed" >&2
    exit 1
  fi
  # The build's tools are plain Python.
  PYTHONPATH=$(python -c 'import sysconfig; print(sysconfig.get_path("purelib"))') build
  local work
  work=$(mktemp -d)
  python -m wheel unpack --dest "$work" "$plain"/engram_sim-*.whl
  sed -i '/^Requires-Dist: nanobind-backend/d' "$work"/*/*.dist-info/METADATA
  rm "$plain"/*.whl
  python -m wheel pack --dest-dir "$plain" "$work"/*
  rm -rf "$work"
  finish 2_34 "$(uname -m)"
}

# The arm64 packages are unpacked in a folder and not installed, so nothing of them has to run.
unpack_sysroot() {
  [ ! -e "$sysroot/usr/include" ] || return 0
  scripts/install_dependencies.sh g++-aarch64-linux-gnu mmdebstrap
  local packages
  packages=$(scripts/install_dependencies.sh --list-libraries | paste -sd,)
  mmdebstrap --variant=extract --architectures=arm64 --include="$packages" \
    bookworm "$sysroot.new" "$(scripts/install_dependencies.sh --mirror)"
  mv "$sysroot.new" "$sysroot"
}

# Debian's libccd for ARM has fused multiply-adds, from which cylinders that touch boxes get other
# contacts than on x86-64. This one, of the same sources with Debian's settings, has none.
libccd() {  # COMPILER... -> $ccd/libccd.so.2
  ccd=$PWD/build/libccd-aarch64
  [ ! -e "$ccd/libccd.so.2" ] || return 0
  local mirror name=libccd_2.1.orig.tar.gz
  mirror=$(scripts/install_dependencies.sh --mirror)
  rm -rf "$ccd"
  mkdir -p "$ccd/config/ccd"
  python -c 'import sys, urllib.request; urllib.request.urlretrieve(*sys.argv[1:])' \
    "${mirror%/}/pool/main/libc/libccd/$name" "$ccd/$name"
  echo "3543093486a8bdb7129e18d69d8f2b42e3056877521425210f9fe560789ebba5  $ccd/$name" |
    sha256sum --check --quiet
  tar -xzf "$ccd/$name" -C "$ccd" --strip-components=1
  echo '#define CCD_DOUBLE' >"$ccd/config/ccd/config.h"
  "$@" -O2 -DNDEBUG -Dccd_EXPORTS -ffp-contract=off \
    -fstack-protector-strong -fvisibility=hidden -fPIC -shared -s -Wl,-soname,libccd.so.2 \
    -Wl,-z,relro,-z,now -I"$ccd/src" -I"$ccd/config" "$ccd"/src/{ccd,mpr,polytope,support,vec3}.c -lm \
    -o "$ccd/libccd.so.new"
  mv "$ccd/libccd.so.new" "$ccd/libccd.so.2"
}

aarch64() {
  unpack_sysroot
  libccd aarch64-linux-gnu-gcc --sysroot="$sysroot"
  local stub=$PWD/build/wheel-stub native
  native=$(newest "-abi3-manylinux*_$(uname -m)")
  if [ -z "$native" ]; then
    echo "wheel.sh: no wheel for $(uname -m) in $dist, which aarch64 takes the stub from; run" \
      "wheel.sh native first" >&2
    exit 1
  fi
  rm -rf "$stub"
  python -m zipfile -e "$native" "$stub"
  CC=aarch64-linux-gnu-gcc CXX=aarch64-linux-gnu-g++ _PYTHON_HOST_PLATFORM=linux-aarch64 build \
    CMAKE_TOOLCHAIN_FILE="$PWD/cmake/toolchains/aarch64.cmake" ENGRAM_SYSROOT="$sysroot" \
    Python_INCLUDE_DIR="$sysroot/usr/include/python3.11" \
    ENGRAM_PYTHON_STUB="$stub/engram/_core.pyi"
  AUDITWHEEL_LD_LIBRARY_PATH="$ccd:$sysroot/usr/lib/aarch64-linux-gnu:$sysroot/lib/aarch64-linux-gnu" \
    finish 2_34 aarch64
}

sdist() { python -m build --sdist --no-isolation --outdir "$dist" .; }

for kind in "${@:-native}"; do
  case $kind in
    native | aarch64 | sdist) "$kind" ;;
    free-threaded) free_threaded ;;
    *)
      echo "wheel.sh: '$kind' given; native, aarch64, free-threaded and sdist allowed" >&2
      exit 2
      ;;
  esac
done
ls -l "$dist"
