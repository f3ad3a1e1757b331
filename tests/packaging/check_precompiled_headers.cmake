# A header that changes in two trees which share ccache's files is compiled as it is in each.
# Variables: DEFAULTS (cmake/EngramDefaults.cmake), WORK, CXX, GENERATOR
file(REMOVE_RECURSE "${WORK}")
set(ENV{CCACHE_DIR} "${WORK}/ccache")

function(write_header tree value)
  file(WRITE "${WORK}/${tree}/value.h" "#pragma once\ninline int value() { return ${value}; }\n")
endfunction()

function(check_value tree value)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK}/${tree}/build"
    OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "the build of ${tree} failed:\n${output}")
  endif()
  execute_process(COMMAND "${WORK}/${tree}/build/value" RESULT_VARIABLE result)
  if(NOT result EQUAL value)
    message(FATAL_ERROR "${tree} was compiled with the value ${result}, its header has ${value}")
  endif()
endfunction()

foreach(tree first second)
  write_header(${tree} 1)
  file(WRITE "${WORK}/${tree}/main.cc" "#include \"value.h\"\nint main() { return value(); }\n")
  file(WRITE "${WORK}/${tree}/CMakeLists.txt"
    "cmake_minimum_required(VERSION 3.25)\nproject(value LANGUAGES CXX)\n"
    "include(\"${DEFAULTS}\")\nadd_executable(value main.cc)\n"
    "target_precompile_headers(value PRIVATE value.h)\n")
  execute_process(COMMAND "${CMAKE_COMMAND}" -S "${WORK}/${tree}" -B "${WORK}/${tree}/build"
    -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  check_value(${tree} 1)
endforeach()
# Both changes start from the same precompiled header.
write_header(first 2)
check_value(first 2)
write_header(second 3)
check_value(second 3)
