# engram_add_tasks(<target> <source>...): a library of tasks, lib<target>.so, which
# `engram --tasks`, ENGRAM_TASKS and engram.load_tasks load (docs/cpp_tasks.md). It is compiled
# as engram is: the same seed then gives the same bits on every machine.
function(engram_add_tasks target)
  if(NOT TARGET engram::tasks)  # the installed package: only who makes tasks needs these two
    find_package(Eigen3 3.4 REQUIRED NO_MODULE)
    find_package(tinyxml2 REQUIRED)
    include("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/engramTasksTargets.cmake")
  endif()
  add_library(${target} MODULE ${ARGN})
  set_target_properties(${target} PROPERTIES
    CXX_EXTENSIONS OFF CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_include_directories(${target} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
  target_compile_options(${target} PRIVATE
    -ffp-contract=off $<$<STREQUAL:$<CONFIG>,>:-O3>)  # fast where no build type is chosen
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64)
    target_compile_options(${target} PRIVATE -U__ARM_FEATURE_FMA)
  endif()
  target_link_libraries(${target} PRIVATE engram::tasks)
  # What is missing is an error here, not when the library is loaded.
  target_link_options(${target} PRIVATE -Wl,--as-needed -Wl,--exclude-libs,ALL -Wl,-z,defs)
endfunction()
