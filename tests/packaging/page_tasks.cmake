# cmake -DPAGE=<docs/cpp_tasks.md> -DFOLDER=<folder> -P page_tasks.cmake
# Writes what the page tells people to write who add a task outside of the tree: every block of code
# whose first line names its file.

file(READ "${PAGE}" text)
set(files "")
while(text MATCHES "\n```(cpp|cmake)\n(//|#) ([A-Za-z_/]+[.](h|cc|txt))\n([^`]+)```\n")
  set(block "${CMAKE_MATCH_0}")
  set(file "${CMAKE_MATCH_3}")
  file(WRITE "${FOLDER}/${file}" "${CMAKE_MATCH_5}")
  list(APPEND files "${file}")
  string(FIND "${text}" "${block}" begin)
  string(SUBSTRING "${text}" ${begin} -1 text)
  string(LENGTH "${block}" length)
  math(EXPR length "${length} - 1")
  string(SUBSTRING "${text}" ${length} -1 text)
endwhile()
list(SORT files)
set(expected CMakeLists.txt library.cc tasks/touch_spot/expert.cc tasks/touch_spot/expert.h
  tasks/touch_spot/task.cc tasks/touch_spot/task.h)
if(NOT files STREQUAL expected)
  message(FATAL_ERROR "${PAGE} has blocks for '${files}'; expected are '${expected}'")
endif()
