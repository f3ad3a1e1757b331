# Settings of the whole build, chosen before any target exists.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release or RelWithDebInfo" FORCE)
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)  # for scripts/tidy.sh
option(ENGRAM_PCH "Precompile the headers that most files include, for faster cold builds" ON)
option(ENGRAM_UNITY "Compile files of a folder as one, for faster cold builds" ON)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
  if(ENGRAM_PCH)
    # ccache stores what is compiled with precompiled headers only if told that macros do not matter,
    # and finds it from other build folders only by paths that are relative. It looks at times of
    # files: a header that changes while it is precompiled would be stored in its old form.
    # The user's own settings stay.
    foreach(setting sloppiness base_dir)
      execute_process(COMMAND "${CCACHE_PROGRAM}" --get-config ${setting}
        OUTPUT_VARIABLE ccache_${setting} OUTPUT_STRIP_TRAILING_WHITESPACE)
    endforeach()
    string(APPEND ccache_sloppiness ",pch_defines,time_macros")
    string(REGEX REPLACE "^," "" ccache_sloppiness "${ccache_sloppiness}")
    string(REPLACE ", " "," ccache_sloppiness "${ccache_sloppiness}")
    if(NOT ccache_base_dir)
      set(ccache_base_dir "${PROJECT_SOURCE_DIR}")
    endif()
    set(CMAKE_CXX_COMPILER_LAUNCHER env "CCACHE_SLOPPINESS=${ccache_sloppiness}"
      "CCACHE_BASEDIR=${ccache_base_dir}" "${CMAKE_CURRENT_LIST_DIR}/ccache.sh" "${CCACHE_PROGRAM}")
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>)
    elseif(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
      add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:SHELL:-Xclang -fno-pch-timestamp>")
    endif()
  endif()
endif()

# scripts/wheel.sh and scripts/package.sh set this, for the files of a release.
option(ENGRAM_HARDEN "Protect stacks, check copies into buffers, bind symbols at the start" OFF)
if(ENGRAM_HARDEN)
  add_compile_options(-fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
  add_link_options(-Wl,-z,relro -Wl,-z,now)
endif()

# Sanitizers change the ABI of what they instrument, so they go on every target at once.
set(ENGRAM_SANITIZE "" CACHE STRING
    "Sanitizer: address, undefined, address,undefined, thread, or empty for none")
set_property(CACHE ENGRAM_SANITIZE PROPERTY STRINGS "" address undefined address,undefined thread)
if(ENGRAM_SANITIZE)
  if(NOT ENGRAM_SANITIZE MATCHES "^(address|undefined|thread|address,undefined)$")
    message(FATAL_ERROR "ENGRAM_SANITIZE is '${ENGRAM_SANITIZE}'; "
                        "allowed are address, undefined, thread, address,undefined and empty")
  endif()
  # -O1 halves the time to compile and keeps the stacks of reports whole.
  add_compile_options(-fsanitize=${ENGRAM_SANITIZE} -fno-sanitize-recover=all -O1 -g1
                      -fno-omit-frame-pointer)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # Instrumented code makes GCC 12 see uninitialised values in its own <regex>.
    add_compile_options(-Wno-maybe-uninitialized)
  endif()
  add_link_options(-fsanitize=${ENGRAM_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND ENGRAM_SANITIZE STREQUAL thread)
    # Clang's runtime for C++ has an operator new where the tests have theirs
    # (tests/allocation_counter.cc), so the runtime for C is linked instead.
    execute_process(
      COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libclang_rt.tsan-x86_64.a
      OUTPUT_VARIABLE runtime OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    set(is_executable $<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>)
    add_link_options(-fno-sanitize-link-runtime
      "$<${is_executable}:SHELL:-Wl,--whole-archive ${runtime} -Wl,--no-whole-archive>"
      "$<${is_executable}:SHELL:-Wl,--export-dynamic -lm -ldl -lrt -lpthread>")
  endif()
endif()

# Fuzz targets (tests/fuzz) need all code under test to report what it covers, and what it breaks.
option(ENGRAM_FUZZ "Build the fuzz targets, with Clang and its sanitizers" OFF)
if(ENGRAM_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    message(FATAL_ERROR "ENGRAM_FUZZ needs Clang; the compiler is ${CMAKE_CXX_COMPILER_ID}")
  endif()
  # Those of "undefined" that report bad numbers; all of it makes builds and runs twice as long.
  set(fuzz_sanitizers
    address,bounds,shift,signed-integer-overflow,integer-divide-by-zero,float-cast-overflow,enum,bool)
  add_compile_options(-fsanitize=fuzzer-no-link,${fuzz_sanitizers} -fno-sanitize-recover=all
                      -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${fuzz_sanitizers})
endif()
