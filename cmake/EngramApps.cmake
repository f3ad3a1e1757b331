# The engram command, with the benchmarks behind `engram bench`.

engram_sources(bench_sources bench)
if(bench_sources)
  add_library(engram_bench STATIC ${bench_sources})
  engram_configure_cold_target(engram_bench)
  engram_share_precompiled(engram_bench engram_cold_objects)
  engram_unity(engram_bench)
  target_link_libraries(engram_bench PUBLIC engram::engram)
endif()

# Everything but the main function is a library, for the tests.
engram_sources(command_sources apps)
list(REMOVE_ITEM command_sources "${PROJECT_SOURCE_DIR}/apps/main.cc")
if(command_sources)
  find_package(CLI11 REQUIRED)
  find_package(fmt REQUIRED)

  add_library(engram_commands STATIC ${command_sources})
  engram_configure_cold_target(engram_commands)
  engram_share_precompiled(engram_commands engram_cold_objects)
  engram_unity(engram_commands)
  target_link_libraries(engram_commands
    PUBLIC engram::engram engram_media fmt::fmt PRIVATE CLI11::CLI11)
  if(TARGET engram_bench)
    target_link_libraries(engram_commands PUBLIC engram_bench)
  endif()

  add_executable(engram_cli "${PROJECT_SOURCE_DIR}/apps/main.cc")
  engram_configure_cold_target(engram_cli)
  engram_share_precompiled(engram_cli engram_cold_objects)
  target_compile_options(engram_cli PRIVATE -fPIC)  # as the precompiled header is, not -fPIE
  set_target_properties(engram_cli PROPERTIES OUTPUT_NAME engram)
  target_link_libraries(engram_cli PRIVATE engram_commands)
endif()

# Programs as users write them: they see the public headers only, and link what is installed.
if(TARGET engram_shared)
  foreach(example cross_entropy half_batches)
    add_executable(engram_${example} "${PROJECT_SOURCE_DIR}/apps/examples/${example}.cc")
    engram_configure_target(engram_${example} PUBLIC_HEADERS_ONLY)
    set_target_properties(engram_${example} PROPERTIES OUTPUT_NAME ${example})
    target_link_libraries(engram_${example} PRIVATE engram_shared Eigen3::Eigen)
  endforeach()
endif()
