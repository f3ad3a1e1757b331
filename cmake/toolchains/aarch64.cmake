# Builds for aarch64 on another Debian: with its cross-compiler (g++-aarch64-linux-gnu), against the
# arm64 packages unpacked in ENGRAM_SYSROOT, as scripts/wheel.sh does.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_STRIP aarch64-linux-gnu-strip)

set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ENGRAM_SYSROOT)
set(CMAKE_SYSROOT "${ENGRAM_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

set(ENV{PKG_CONFIG_DIR} "")
set(ENV{PKG_CONFIG_LIBDIR}
  "${ENGRAM_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${ENGRAM_SYSROOT}/usr/share/pkgconfig")
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${ENGRAM_SYSROOT}")
