# Tests of the APIs that are programs of their own: in plain C, and of the installed package.

set(engram_api_library engram::engram)
if(TARGET engram_shared)
  set(engram_api_library engram_shared)
endif()

add_executable(engram_c_program "${PROJECT_SOURCE_DIR}/tests/api/c_program.c")
set_target_properties(engram_c_program PROPERTIES
  C_STANDARD 11 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF LINKER_LANGUAGE C)
if(ENGRAM_SANITIZE)  # which have a part for C++
  set_target_properties(engram_c_program PROPERTIES LINKER_LANGUAGE CXX)
endif()
target_compile_options(engram_c_program PRIVATE -Wall -Wextra -Wpedantic -Werror)
target_link_libraries(engram_c_program PRIVATE ${engram_api_library})
add_test(NAME c_program COMMAND engram_c_program)

if(TARGET engram_cross_entropy)
  add_test(NAME cross_entropy_example COMMAND engram_cross_entropy 2)
  set_tests_properties(cross_entropy_example PROPERTIES TIMEOUT 300
    PASS_REGULAR_EXPRESSION "trained: +return [0-9.-]+, success [01]")
  add_test(NAME half_batches_example COMMAND engram_half_batches 16 1)
  set_tests_properties(half_batches_example PROPERTIES TIMEOUT 300
    PASS_REGULAR_EXPRESSION "two halves +[1-9]")
endif()

# Programs of others would have to be instrumented as the library is.
if(TARGET engram_shared AND NOT ENGRAM_SANITIZE)
  add_test(NAME exported_symbols COMMAND "${CMAKE_COMMAND}" "-DNM=${CMAKE_NM}"
    "-DLIBRARY=$<TARGET_FILE:engram_shared>" "-DHEADERS=${PROJECT_SOURCE_DIR}/api/engram"
    -P "${PROJECT_SOURCE_DIR}/tests/packaging/check_symbols.cmake")
  find_program(ENGRAM_PKG_CONFIG pkg-config REQUIRED)
  add_test(NAME installed_package COMMAND "${CMAKE_COMMAND}" "-DBUILD=${PROJECT_BINARY_DIR}"
    "-DPROJECT=${PROJECT_SOURCE_DIR}/tests/packaging/project"
    "-DPAGE=${PROJECT_SOURCE_DIR}/docs/embedding.md"
    "-DTASK_PAGE=${PROJECT_SOURCE_DIR}/docs/cpp_tasks.md"
    "-DCOMPONENTS=runtime$<SEMICOLON>development$<$<TARGET_EXISTS:engram_cli>:$<SEMICOLON>command>"
    "-DWORK=${PROJECT_BINARY_DIR}/tests/packaging" "-DCC=${CMAKE_C_COMPILER}"
    "-DCXX=${CMAKE_CXX_COMPILER}" "-DPKG_CONFIG=${ENGRAM_PKG_CONFIG}"
    -P "${PROJECT_SOURCE_DIR}/tests/packaging/check_installed.cmake")
  set_tests_properties(installed_package PROPERTIES TIMEOUT 900)
  add_test(NAME added_folder COMMAND "${CMAKE_COMMAND}" "-DSOURCE=${PROJECT_SOURCE_DIR}"
    "-DWORK=${PROJECT_BINARY_DIR}/tests/packaging_added" "-DCC=${CMAKE_C_COMPILER}"
    "-DCXX=${CMAKE_CXX_COMPILER}" "-DGENERATOR=${CMAKE_GENERATOR}"
    -P "${PROJECT_SOURCE_DIR}/tests/packaging/check_added_folder.cmake")
  if(CCACHE_PROGRAM)
    add_test(NAME precompiled_headers COMMAND "${CMAKE_COMMAND}"
      "-DDEFAULTS=${PROJECT_SOURCE_DIR}/cmake/EngramDefaults.cmake"
      "-DWORK=${PROJECT_BINARY_DIR}/tests/packaging_headers" "-DCXX=${CMAKE_CXX_COMPILER}"
      "-DGENERATOR=${CMAKE_GENERATOR}"
      -P "${PROJECT_SOURCE_DIR}/tests/packaging/check_precompiled_headers.cmake")
  endif()
  if(TARGET engram_cli)
    add_test(NAME wheel_package COMMAND "${CMAKE_COMMAND}" "-DBUILD=${PROJECT_BINARY_DIR}"
      "-DTASK_PAGE=${PROJECT_SOURCE_DIR}/docs/cpp_tasks.md"
      "-DCOMMAND=${PROJECT_SOURCE_DIR}/python/engram/command" "-DENGRAM=$<TARGET_FILE:engram_cli>"
      "-DWORK=${PROJECT_BINARY_DIR}/tests/packaging_wheel" "-DCXX=${CMAKE_CXX_COMPILER}"
      "-DPYTHON=${Python3_EXECUTABLE}"
      -P "${PROJECT_SOURCE_DIR}/tests/packaging/check_wheel_package.cmake")
    set_tests_properties(wheel_package PROPERTIES TIMEOUT 600)
  endif()
endif()

# A host project that adds this one sees the public headers, and none of the engine's own.
get_target_property(public_folders engram_objects INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER public_folders INCLUDE REGEX "^${PROJECT_SOURCE_DIR}")
if(NOT public_folders STREQUAL "${PROJECT_SOURCE_DIR}/api")
  message(FATAL_ERROR "folders that a host project sees: '${public_folders}'; allowed: api")
endif()
