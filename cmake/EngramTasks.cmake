# Tasks outside of this tree: the headers that they are compiled with, the archive that they are
# linked with, and engram_add_tasks().

# engram_add_includes(<variable> [<extension>]): adds to the list of files what they include of the
# project's own; with an extension, also the files of that extension beside headers.
function(engram_add_includes variable)
  set(open ${${variable}})
  set(all "")
  while(open)
    list(POP_FRONT open file)
    if(file IN_LIST all OR NOT EXISTS "${PROJECT_SOURCE_DIR}/${file}")
      continue()
    endif()
    list(APPEND all "${file}")
    file(STRINGS "${PROJECT_SOURCE_DIR}/${file}" included REGEX "^#include \"")
    list(TRANSFORM included REPLACE "^#include \"([^\"]+)\".*$" "\\1")
    list(APPEND open ${included})
    if(ARGC GREATER 1 AND NOT file STREQUAL tasks/registry.h)  # which is the engine's own
      string(REGEX REPLACE "[.]h$" "${ARGV1}" beside "${file}")
      list(APPEND open "${beside}")
    endif()
  endwhile()
  list(SORT all)
  set(${variable} ${all} PARENT_SCOPE)
endfunction()

# Headers: those that the benchmark's own tasks include, and what these include. What is in a
# family's folder is for nobody else.
file(GLOB task_headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}"
  "${PROJECT_SOURCE_DIR}/tasks/*/*.h" "${PROJECT_SOURCE_DIR}/tasks/*/*.cc")
list(APPEND task_headers tasks/task_library.h mjcf/mesh.h mjcf/mesh_geom.h)
engram_add_includes(task_headers)
list(FILTER task_headers INCLUDE REGEX "^(core|mjcf|tasks/common)/.*[.]h$|^tasks/[a-z_]+[.]h$")

# The version, and a checksum of the headers: the engine takes libraries of tasks that have the same.
set(checksums "")
foreach(header IN LISTS task_headers)
  file(SHA256 "${PROJECT_SOURCE_DIR}/${header}" checksum)
  string(APPEND checksums "${header} ${checksum}\n")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${header}")
endforeach()
string(SHA256 checksum "${checksums}")
string(SUBSTRING "${checksum}" 0 16 ENGRAM_TASKS_HEADERS)
set(engram_tasks_stamp "${PROJECT_BINARY_DIR}/tasks/include")
configure_file("${CMAKE_CURRENT_LIST_DIR}/task_library_stamp.h.in"
  "${engram_tasks_stamp}/tasks/task_library_stamp.h" @ONLY)
set_source_files_properties(protocol/make/task_library.cc PROPERTIES
  INCLUDE_DIRECTORIES "${engram_tasks_stamp}")

# The archive: the code behind those headers. A library of tasks has its own copy of what it uses,
# hidden, and needs no symbol of the program that loads it.
set(task_sources ${task_headers})
engram_add_includes(task_sources .cc)
list(FILTER task_sources INCLUDE REGEX "[.]cc$")
list(JOIN task_sources "|" task_objects)
string(REPLACE "." "[.]" task_objects "${task_objects}")
engram_unity(engram_objects ${task_sources})
engram_unity(engram_cold_objects ${task_sources})
add_library(engram_tasks STATIC
  "$<FILTER:$<TARGET_OBJECTS:engram_objects>;$<TARGET_OBJECTS:engram_cold_objects>,INCLUDE,/(${task_objects}|unity_member_.*)[.]o$>")
add_library(engram::tasks ALIAS engram_tasks)
set_target_properties(engram_tasks PROPERTIES LINKER_LANGUAGE CXX EXPORT_NAME tasks)
target_include_directories(engram_tasks INTERFACE
  "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR};${engram_tasks_stamp}>")
target_compile_features(engram_tasks INTERFACE cxx_std_20)
target_link_libraries(engram_tasks INTERFACE Eigen3::Eigen tinyxml2::tinyxml2)

include(EngramAddTasks)

# engram_install_tasks(<component> <headers> <lib> [EXCLUDE_FROM_ALL]): headers, archive and CMake
# package, each in a folder under the prefix.
function(engram_install_tasks component headers lib)
  set(made "${PROJECT_BINARY_DIR}/install/${component}")
  set(package "${lib}/cmake/engram")
  configure_package_config_file("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/engramConfig.cmake.in"
    "${made}/engramConfig.cmake" INSTALL_DESTINATION "${package}")
  write_basic_package_version_file("${made}/engramConfigVersion.cmake"
    COMPATIBILITY SameMinorVersion)
  install(FILES "${made}/engramConfig.cmake" "${made}/engramConfigVersion.cmake"
    "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/EngramAddTasks.cmake"
    DESTINATION "${package}" COMPONENT ${component} ${ARGN})
  install(TARGETS engram_tasks EXPORT ${component}_tasks
    ARCHIVE DESTINATION "${lib}" COMPONENT ${component} ${ARGN}
    INCLUDES DESTINATION "${headers}")
  install(EXPORT ${component}_tasks FILE engramTasksTargets.cmake NAMESPACE engram::
    DESTINATION "${package}" COMPONENT ${component} ${ARGN})
  foreach(header IN LISTS task_headers)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES "${PROJECT_SOURCE_DIR}/${header}" DESTINATION "${headers}/${folder}"
      COMPONENT ${component} ${ARGN})
  endforeach()
  install(FILES "${engram_tasks_stamp}/tasks/task_library_stamp.h"
    DESTINATION "${headers}/tasks" COMPONENT ${component} ${ARGN})
endfunction()

include(CMakePackageConfigHelpers)
if(ENGRAM_INSTALL)
  include(GNUInstallDirs)
  engram_install_tasks(development "${CMAKE_INSTALL_INCLUDEDIR}/engram-tasks"
    "${CMAKE_INSTALL_LIBDIR}")
endif()
# In wheels, inside the Python package: `python -m engram --cmake-dir`.
engram_install_tasks(wheel engram/include engram/lib EXCLUDE_FROM_ALL)
