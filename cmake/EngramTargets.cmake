# What every target of this project shares.

# engram_sources(<variable> <folder>...): the .cc files that lie directly in the folders (which may
# be wildcards and may be empty).
function(engram_sources variable)
  list(TRANSFORM ARGN APPEND "/*.cc" OUTPUT_VARIABLE patterns)
  list(TRANSFORM patterns PREPEND "${PROJECT_SOURCE_DIR}/")
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  set(${variable} ${sources} PARENT_SCOPE)
endfunction()

# engram_configure_target(<target> [PUBLIC_HEADERS_ONLY]): language level, warnings, and floating
# point whose bits do not depend on whether the compiler finds a fused multiply-add. The project's
# folders are on the include path of its own targets alone: a host project sees api/.
function(engram_configure_target target)
  if(NOT "PUBLIC_HEADERS_ONLY" IN_LIST ARGN)
    target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}")
  endif()
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF
    COMPILE_WARNING_AS_ERROR ${ENGRAM_WARNINGS_AS_ERRORS})
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -ffp-contract=off)
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64)
    # Or whether Eigen writes one itself, which it does where this is defined.
    target_compile_options(${target} PRIVATE -U__ARM_FEATURE_FMA)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False alarms about std::string (GCC bug 105329).
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-array-bounds -Wno-stringop-overflow)
  endif()
endfunction()

# engram_hide_symbols(<target>): code that a shared library may contain and nobody sees.
function(engram_hide_symbols target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# engram_configure_cold_target(<target>): what takes no share of a step's time, compiled sooner.
function(engram_configure_cold_target target)
  engram_configure_target(${target})
  engram_hide_symbols(${target})
  # Copies are checked as in the wheel, whose headers have warnings of their own.
  target_compile_options(${target} PRIVATE
    $<$<CONFIG:Release>:-O1> $<$<CONFIG:Release>:-U_FORTIFY_SOURCE> $<$<CONFIG:Release>:-D_FORTIFY_SOURCE=2>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)  # false alarms of -O1
  endif()
endfunction()

# What nearly every file includes, directly or by way of our own headers.
set(ENGRAM_COMMON_HEADERS
  <algorithm> <array> <atomic> <chrono> <cmath> <cstddef> <cstdint> <cstring> <functional> <limits>
  <map> <memory> <mutex> <numbers> <numeric> <optional> <span> <string> <string_view> <thread>
  <utility> <variant> <vector>
  <Eigen/Dense> <mujoco/mujoco.h>
  # Ours that nearly all files see anyway: a change to one compiles everything anew as it is.
  "${PROJECT_SOURCE_DIR}/core/batch/batch.h" "${PROJECT_SOURCE_DIR}/mjcf/scene.h"
  "${PROJECT_SOURCE_DIR}/protocol/io/json.h")

# engram_precompile(<target> <header>...): compiles those headers once for the whole target. Files
# include what they need all the same: without ENGRAM_PCH, and for clang-tidy, they stand alone.
function(engram_precompile target)
  if(ENGRAM_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# engram_share_precompiled(<target> <other>): the target, configured as the other one is, uses what
# that one has precompiled.
function(engram_share_precompiled target other)
  if(ENGRAM_PCH)
    target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:${other},COMPILE_DEFINITIONS>)
    target_precompile_headers(${target} REUSE_FROM ${other})
  endif()
endfunction()

# engram_unity(<target> [<member>...]): compiles up to sixteen files of a folder as one; names in the
# anonymous namespaces of a folder are therefore different. Members are files that an archive takes
# from the target: they form groups of their own, whose names begin with "member_". Files with
# options of their own stay alone.
function(engram_unity target)
  if(NOT ENGRAM_UNITY OR NOT ENGRAM_PCH)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    file(RELATIVE_PATH source "${PROJECT_SOURCE_DIR}" "${source}")
    cmake_path(GET source PARENT_PATH group)
    string(REPLACE "/" "_" group "${group}")
    if(source IN_LIST ARGN)
      string(PREPEND group "member_")
    endif()
    list(APPEND groups ${group})
    list(APPEND files_${group} "${PROJECT_SOURCE_DIR}/${source}")
  endforeach()
  list(REMOVE_DUPLICATES groups)
  foreach(group IN LISTS groups)
    list(LENGTH files_${group} count)
    math(EXPR parts "(${count} + 15) / 16")
    set(index 0)
    foreach(source IN LISTS files_${group})
      math(EXPR part "${index} * ${parts} / ${count}")
      set_property(SOURCE "${source}" PROPERTY UNITY_GROUP ${group}_${part})
      math(EXPR index "${index} + 1")
    endforeach()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # Of names in another file: checked where files stand alone.
  target_compile_options(${target} PRIVATE
    -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()
