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
list(APPEND task_headers tasks/task_library.h)
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
set_source_files_properties(protocol/batch/task_library.cc PROPERTIES
  INCLUDE_DIRECTORIES "${engram_tasks_stamp}")

# The archive: the code behind those headers. A library of tasks has its own copy of what it uses,
# hidden, and needs no symbol of the program that loads it.
set(task_sources ${task_headers})
engram_add_includes(task_sources .cc)
list(FILTER task_sources INCLUDE REGEX "[.]cc$")
list(JOIN task_sources "|" task_objects)
string(REPLACE "." "[.]" task_objects "${task_objects}")
add_library(engram_tasks STATIC
  "$<FILTER:$<TARGET_OBJECTS:engram_objects>,INCLUDE,/(${task_objects})[.]o$>")
add_library(engram::tasks ALIAS engram_tasks)
set_target_properties(engram_tasks PROPERTIES LINKER_LANGUAGE CXX EXPORT_NAME tasks)
target_include_directories(engram_tasks INTERFACE
  "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR};${engram_tasks_stamp}>")
target_compile_features(engram_tasks INTERFACE cxx_std_20)
target_link_libraries(engram_tasks INTERFACE Eigen3::Eigen tinyxml2::tinyxml2)

include(EngramAddTasks)

if(ENGRAM_INSTALL)
  include(GNUInstallDirs)
  set(tasks_folder "${CMAKE_INSTALL_INCLUDEDIR}/engram-tasks")
  target_include_directories(engram_tasks INTERFACE "$<INSTALL_INTERFACE:${tasks_folder}>")
  install(TARGETS engram_tasks EXPORT engramTasksTargets ARCHIVE COMPONENT development)
  foreach(header IN LISTS task_headers)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES "${PROJECT_SOURCE_DIR}/${header}" DESTINATION "${tasks_folder}/${folder}"
      COMPONENT development)
  endforeach()
  install(FILES "${engram_tasks_stamp}/tasks/task_library_stamp.h"
    DESTINATION "${tasks_folder}/tasks" COMPONENT development)
endif()
