# cmake -DPAGE=<docs/embedding.md> -DPROJECT=<outside project> -DFOLDER=<its copy> -P page_project.cmake
# Copies the project, and beside it what the page tells C++ users to write: page.cmake and page.cc.

file(REMOVE_RECURSE "${FOLDER}")
file(COPY "${PROJECT}/" DESTINATION "${FOLDER}")
file(READ "${PAGE}" text)
foreach(block cmake:page.cmake cpp:page.cc)
  string(REPLACE ":" ";" block "${block}")
  list(GET block 0 language)
  list(GET block 1 file)
  if(NOT text MATCHES "\n```${language}\n([^`]+)```\n")
    message(FATAL_ERROR "${PAGE} has no block of ${language}")
  endif()
  file(WRITE "${FOLDER}/${file}" "${CMAKE_MATCH_1}")
endforeach()
