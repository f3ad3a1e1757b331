# cmake -DNM=... -DLIBRARY=libengram.so -DHEADERS=api/engram -P check_symbols.cmake
# The library exports what the headers of C in that folder declare, and nothing else.

execute_process(COMMAND "${NM}" -D --defined-only "${LIBRARY}"
  OUTPUT_VARIABLE table COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${table}")
set(exported "")
foreach(line IN LISTS lines)
  string(REGEX REPLACE "^[0-9a-f]+ [A-Za-z] ([^@ ]+).*$" "\\1" symbol "${line}")
  if(NOT symbol STREQUAL "ENGRAM_0")  # the version itself
    list(APPEND exported "${symbol}")
  endif()
endforeach()

set(text "")
file(GLOB headers "${HEADERS}/*_c.h" "${HEADERS}/engram_task.h")
foreach(header IN LISTS headers)
  file(READ "${header}" one)
  string(APPEND text "${one}")
endforeach()
string(REGEX MATCHALL "ENGRAM_API [^;(]*engram_[a-z_0-9]+\\(" declarations "${text}")
list(TRANSFORM declarations REPLACE "^.*(engram_[a-z_0-9]+)\\($" "\\1" OUTPUT_VARIABLE declared)

list(SORT exported)
list(SORT declared)
list(LENGTH declared count)
if(count LESS 20 OR NOT "${exported}" STREQUAL "${declared}")
  message(FATAL_ERROR "exported: ${exported}\ndeclared: ${declared}")
endif()
message("${count} functions, all declared")
