# Libraries of tasks that tests load: the one of docs/cpp_tasks.md, and some to refuse.

set(libraries "${PROJECT_BINARY_DIR}/tests/task_libraries")
set(page "${PROJECT_SOURCE_DIR}/docs/cpp_tasks.md")
set(page_script "${PROJECT_SOURCE_DIR}/tests/packaging/page_tasks.cmake")
set(page_sources library.cc tasks/touch_spot/task.cc tasks/touch_spot/expert.cc)
list(TRANSFORM page_sources PREPEND "${libraries}/page/")
add_custom_command(OUTPUT ${page_sources}
  COMMAND "${CMAKE_COMMAND}" "-DPAGE=${page}" "-DFOLDER=${libraries}/page" -P "${page_script}"
  DEPENDS "${page}" "${page_script}")
engram_add_tasks(engram_touch_spot ${page_sources})
target_include_directories(engram_touch_spot PRIVATE "${libraries}/page")
set(test_libraries touch_spot)

set(folder "${PROJECT_SOURCE_DIR}/tests/protocol/make/task_libraries")
foreach(name no_entry taken_id)
  engram_add_tasks(engram_${name} "${folder}/${name}.cc")
  list(APPEND test_libraries ${name})
endforeach()
foreach(name no_tasks other_version other_abi other_headers null_version null_description)
  engram_add_tasks(engram_${name} "${folder}/altered.cc")
  list(APPEND test_libraries ${name})
endforeach()
target_compile_definitions(engram_other_version PRIVATE OTHER_VERSION)
target_compile_definitions(engram_other_headers PRIVATE OTHER_HEADERS)
target_compile_definitions(engram_null_version PRIVATE NULL_VERSION)
target_compile_definitions(engram_null_description PRIVATE NULL_DESCRIPTION)
# As -march=native does on many machines.
target_compile_definitions(engram_other_abi PRIVATE EIGEN_MAX_STATIC_ALIGN_BYTES=128)

foreach(name IN LISTS test_libraries)
  set_target_properties(engram_${name} PROPERTIES
    OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY "${libraries}")
  target_compile_options(engram_${name} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror)
  add_dependencies(engram_tests engram_${name})
endforeach()
