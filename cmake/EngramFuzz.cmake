# One program per fuzz target: tests/fuzz/<name>_target.cc becomes fuzz_<name>, which
# scripts/fuzz.sh runs. The same targets replay their corpus in the ordinary tests.

# Scenes are our own: composing and drawing them is of no interest here, only slow to build. So is
# looking for the id that is nearest to a wrong one: it would be most of the time of some targets.
set(plain_sources ${library_sources} ${media_sources})
list(FILTER plain_sources INCLUDE REGEX "/(render|mjcf)/|/tasks/registry.cc$")
set_property(SOURCE ${plain_sources} APPEND PROPERTY COMPILE_OPTIONS -fno-sanitize=all)
set_property(SOURCE ${plain_sources} PROPERTY SKIP_PRECOMPILE_HEADERS ON)  # which are sanitized

find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)

file(GLOB fuzz_targets CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tests/fuzz/*_target.cc")
foreach(source ${fuzz_targets})
  get_filename_component(name "${source}" NAME_WE)
  string(REGEX REPLACE "_target$" "" name "${name}")
  add_executable(fuzz_${name} "${source}" "${PROJECT_SOURCE_DIR}/tests/fuzz/fuzzer_main.cc"
    "${PROJECT_SOURCE_DIR}/tests/fuzz/input.cc" "${PROJECT_SOURCE_DIR}/apps/command_line.cc"
    "${PROJECT_SOURCE_DIR}/apps/options.cc")
  engram_configure_target(fuzz_${name})
  target_compile_definitions(fuzz_${name} PRIVATE ENGRAM_FUZZ_TARGET=fuzz_${name})
  target_link_libraries(fuzz_${name} PRIVATE
    engram::engram engram_media PkgConfig::ENGRAM_MEDIA CLI11::CLI11 fmt::fmt)
  target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
endforeach()
