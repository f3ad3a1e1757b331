# Finds MuJoCo's header and library and defines MuJoCo::MuJoCo. Debian's own package file is not
# used because it asks for the OpenGL headers, which the simulator does not need.
# ENGRAM_MUJOCO_ROOT names another MuJoCo: the folder mujoco of a wheel of PyPI, unpacked. Its library
# has the version in its name.
set(ENGRAM_MUJOCO_ROOT "" CACHE PATH "Folder mujoco of an unpacked wheel; empty: the system's MuJoCo")
if(ENGRAM_MUJOCO_ROOT)
  file(GLOB library "${ENGRAM_MUJOCO_ROOT}/libmujoco.so*")
  set(MuJoCo_LIBRARY "${library}" CACHE FILEPATH "" FORCE)
  set(MuJoCo_INCLUDE_DIR "${ENGRAM_MUJOCO_ROOT}/include" CACHE PATH "" FORCE)
  unset(library)
endif()

find_path(MuJoCo_INCLUDE_DIR mujoco/mujoco.h)
find_library(MuJoCo_LIBRARY mujoco)

# mjVERSION_HEADER is 222 for 2.2.2, and 3017000 for 3.17.0.
if(EXISTS "${MuJoCo_INCLUDE_DIR}/mujoco/mujoco.h")
  file(STRINGS "${MuJoCo_INCLUDE_DIR}/mujoco/mujoco.h" line REGEX "#define mjVERSION_HEADER")
  string(REGEX MATCH "[0-9]+" number "${line}")
  set(base 1000)
  if(number LESS 1000000)
    set(base 10)
  endif()
  math(EXPR major "${number} / ${base} / ${base}")
  math(EXPR minor "${number} / ${base} % ${base}")
  math(EXPR patch "${number} % ${base}")
  set(MuJoCo_VERSION "${major}.${minor}.${patch}")
  foreach(name line number base major minor patch)
    unset(${name})
  endforeach()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(MuJoCo
  REQUIRED_VARS MuJoCo_LIBRARY MuJoCo_INCLUDE_DIR
  VERSION_VAR MuJoCo_VERSION
  HANDLE_VERSION_RANGE)
mark_as_advanced(MuJoCo_INCLUDE_DIR MuJoCo_LIBRARY)

if(MuJoCo_FOUND AND NOT TARGET MuJoCo::MuJoCo)
  add_library(MuJoCo::MuJoCo UNKNOWN IMPORTED)
  set_target_properties(MuJoCo::MuJoCo PROPERTIES
    IMPORTED_LOCATION "${MuJoCo_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${MuJoCo_INCLUDE_DIR}")
endif()
