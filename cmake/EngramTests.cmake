# One test program. ctest runs a process for each file of tests, by the file's name, and one for each
# test case tagged [long], with the label "long": `ctest -LE long` leaves them out.

find_package(Catch2 2.13 REQUIRED)
find_package(nlohmann_json REQUIRED)
include(Catch)

file(GLOB_RECURSE test_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tests/*_test.cc")
if(NOT TARGET engram_cli)  # tests of the command and its benchmarks need them
  list(FILTER test_sources EXCLUDE REGEX "/tests/(apps|bench)/")
endif()
if(ENGRAM_SANITIZE)  # libraries of others would have to be instrumented as the engine is
  list(FILTER test_sources EXCLUDE REGEX "/(load_tasks|task_library|tasks_option)_test[.]cc$")
endif()
engram_sources(test_support tests)  # the main function and shared helpers
if(TARGET engram_cli)  # fuzz targets, on their corpora
  engram_sources(fuzz_sources tests/fuzz)
  list(FILTER fuzz_sources EXCLUDE REGEX "/fuzzer_main.cc$|_test.cc$")
  list(APPEND test_support ${fuzz_sources})
else()
  list(FILTER test_sources EXCLUDE REGEX "/tests/fuzz/")
endif()
add_executable(engram_tests ${test_sources} ${test_support})
engram_configure_target(engram_tests)
engram_precompile(engram_tests ${ENGRAM_COMMON_HEADERS} <filesystem> <catch2/catch.hpp>)
set_property(SOURCE "${PROJECT_SOURCE_DIR}/tests/main.cc" PROPERTY
  SKIP_PRECOMPILE_HEADERS ON)  # has Catch2 compiled, and says so before it includes it
set_property(SOURCE "${PROJECT_SOURCE_DIR}/tests/api/cpp_api_test.cc"
  "${PROJECT_SOURCE_DIR}/tests/api/load_tasks_test.cc"
  "${PROJECT_SOURCE_DIR}/tests/api/training_cpp_test.cc"
  "${PROJECT_SOURCE_DIR}/tests/api/variants_test.cc" PROPERTY
  SKIP_PRECOMPILE_HEADERS ON)  # sees the public header alone, whose names the engine has too
# Tests are compiled once and run briefly: the time to compile them counts.
target_compile_options(engram_tests PRIVATE $<$<CONFIG:Release>:-O1>)
# Clang's and clang-tidy's -Wconversion minds signs too, unlike GCC's, by which the tests go.
target_compile_options(engram_tests PRIVATE -Wno-sign-conversion)
target_link_libraries(engram_tests PRIVATE
  engram::engram engram_media Catch2::Catch2 nlohmann_json::nlohmann_json tinyxml2::tinyxml2)
if(TARGET engram_bench)
  target_link_libraries(engram_tests PRIVATE engram_bench)
endif()
if(TARGET engram_cli)
  add_dependencies(engram_tests engram_cli)
  target_link_libraries(engram_tests PRIVATE
    engram_commands PkgConfig::ENGRAM_LIBAV ${CMAKE_DL_LIBS})
  # Makes the command's results depend on the order of its work.
  add_library(engram_nondeterministic_contacts MODULE "${PROJECT_SOURCE_DIR}/tests/apps/nondeterministic_contacts.cc")
  engram_configure_target(engram_nondeterministic_contacts)
  target_include_directories(engram_nondeterministic_contacts SYSTEM PRIVATE
    $<TARGET_PROPERTY:MuJoCo::MuJoCo,INTERFACE_INCLUDE_DIRECTORIES>)
  add_dependencies(engram_tests engram_nondeterministic_contacts)
endif()
if(NOT ENGRAM_SANITIZE)
  include(EngramTestTasks)
endif()
set_property(SOURCE "${PROJECT_SOURCE_DIR}/tests/build_paths.cc" APPEND PROPERTY COMPILE_DEFINITIONS
  ENGRAM_ROOT="${PROJECT_SOURCE_DIR}"
  ENGRAM_TASK_LIBRARIES="${PROJECT_BINARY_DIR}/tests/task_libraries"
  ENGRAM_CLI="$<$<TARGET_EXISTS:engram_cli>:$<TARGET_FILE:engram_cli>>"
  ENGRAM_NONDETERMINISTIC_CONTACTS="$<$<TARGET_EXISTS:engram_nondeterministic_contacts>:$<TARGET_FILE:engram_nondeterministic_contacts>>")

# What tools/surface writes from the tables of the public surface.
find_package(Python3 3.11 REQUIRED COMPONENTS Interpreter)
add_test(NAME surface_up_to_date
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/tools/surface" --check)

# A process for each file: one for each test case would load the program's libraries 1,900 times.
# Files of the same name share one; one may have no tests but long ones.
list(TRANSFORM test_sources REPLACE ".*/(.+)[.]cc$" "\\1" OUTPUT_VARIABLE test_files)
list(REMOVE_DUPLICATES test_files)
foreach(name IN LISTS test_files)
  add_test(NAME ${name} COMMAND engram_tests --filenames-as-tags "[#${name}]~[long]~[.]")
endforeach()
set_tests_properties(${test_files} PROPERTIES TIMEOUT 900)
# A name that matches no test case fails instead of passing unnoticed. Square brackets and semicolons
# in names of test cases make such names, because CMake reads them as lists.
catch_discover_tests(engram_tests TEST_SPEC "[long]" TEST_LIST engram_long_tests
  EXTRA_ARGS --warn NoTests PROPERTIES LABELS long TIMEOUT 3600)

# The picture of the modules in docs/ fits the #include lines.
add_test(NAME docs_modules
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/tools/docs.py" modules --check)

# Tables and measured results in docs/ fit the output of the command.
find_package(Python3 COMPONENTS Interpreter)
if(TARGET engram_cli AND Python3_Interpreter_FOUND)
  add_test(NAME docs_tables COMMAND Python3::Interpreter
    "${PROJECT_SOURCE_DIR}/tools/docs.py" tables --check --engram $<TARGET_FILE:engram_cli>)
  set_tests_properties(docs_tables PROPERTIES TIMEOUT 300)
  add_test(NAME docs_data COMMAND Python3::Interpreter
    "${PROJECT_SOURCE_DIR}/tools/measure.py" check --engram $<TARGET_FILE:engram_cli>)
  set_tests_properties(docs_data PROPERTIES TIMEOUT 300)
endif()
