# cmake -DSOURCE=<engram's folder> -DWORK=<folder of its own> -DCC=... -DCXX=... -DGENERATOR=...
#       -P check_added_folder.cmake
# Configures a project that has engram's folder in it: it compiles the library alone, and takes the
# warnings of whatever compiler it has for warnings.

file(REMOVE_RECURSE "${WORK}")
file(WRITE "${WORK}/CMakeLists.txt" "
cmake_minimum_required(VERSION 3.25)
project(trainer LANGUAGES C CXX)
add_subdirectory(\"${SOURCE}\" engram)
add_executable(trainer \"${SOURCE}/tests/packaging/project/outside.cc\")
target_link_libraries(trainer PRIVATE engram::engram)
")
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${WORK}" -B "${WORK}/build" -G "${GENERATOR}"
  "-DCMAKE_C_COMPILER=${CC}" "-DCMAKE_CXX_COMPILER=${CXX}" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
  COMMAND_ERROR_IS_FATAL ANY)

file(READ "${WORK}/build/compile_commands.json" commands)
if(commands MATCHES "-Werror")
  message(FATAL_ERROR "a host project's compiler may warn; -Werror given")
endif()
string(REGEX MATCHALL "\"file\": \"[^\"]*\"" files "${commands}")
list(LENGTH files count)
if(count LESS 50)
  message(FATAL_ERROR "${count} files are compiled; the library has more")
endif()
list(FILTER files INCLUDE REGEX "${SOURCE}/(apps|bench|tests)/")
list(FILTER files EXCLUDE REGEX "packaging/project/outside.cc")
if(files)
  message(FATAL_ERROR "a host project compiles the library alone; also given: ${files}")
endif()
