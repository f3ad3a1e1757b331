# cmake -DBUILD=<build folder> -DPROJECT=<outside project> -DPAGE=<docs/embedding.md>
#       -DTASK_PAGE=<docs/cpp_tasks.md> -DCOMPONENTS=<of the installation>
#       -DWORK=<folder of its own> -DCC=... -DCXX=... -DPKG_CONFIG=... -P check_installed.cmake
# Installs the package into a prefix, moves it, and builds and runs a user's programs with it:
# once through find_package, once through pkg-config. Then a user's task, as a library.

macro(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endmacro()

file(REMOVE_RECURSE "${WORK}")
foreach(component IN LISTS COMPONENTS)
  run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/first" --component ${component})
endforeach()
file(RENAME "${WORK}/first" "${WORK}/prefix")

run("${CMAKE_COMMAND}" "-DPAGE=${PAGE}" "-DPROJECT=${PROJECT}" "-DFOLDER=${WORK}/project"
  -P "${CMAKE_CURRENT_LIST_DIR}/page_project.cmake")
run("${CMAKE_COMMAND}" -S "${WORK}/project" -B "${WORK}/cmake" "-DCMAKE_PREFIX_PATH=${WORK}/prefix"
  "-DCMAKE_C_COMPILER=${CC}" "-DCMAKE_CXX_COMPILER=${CXX}")
run("${CMAKE_COMMAND}" --build "${WORK}/cmake")
run("${WORK}/cmake/outside_c")
run("${WORK}/cmake/outside_cpp")

run("${CMAKE_COMMAND}" "-DPAGE=${TASK_PAGE}" "-DFOLDER=${WORK}/tasks"
  -P "${CMAKE_CURRENT_LIST_DIR}/page_tasks.cmake")
run("${CMAKE_COMMAND}" -S "${WORK}/tasks" -B "${WORK}/tasks/build"
  "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DCMAKE_CXX_COMPILER=${CXX}"
  "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror")
run("${CMAKE_COMMAND}" --build "${WORK}/tasks/build")
set(library "${WORK}/tasks/build/libtouch_spot.so")
run("${WORK}/cmake/outside_tasks" "${library}" TouchSpot-VLA-v0)
if(EXISTS "${WORK}/prefix/bin/engram")
  run("${WORK}/prefix/bin/engram" --tasks "${library}" eval TouchSpot-VLA-v0 --policy oracle
    --episodes 32 --out "${WORK}/results")
endif()

file(GLOB_RECURSE pc_file "${WORK}/prefix/engram.pc")
cmake_path(GET pc_file PARENT_PATH pc_folder)
set(ENV{PKG_CONFIG_PATH} "${pc_folder}")
execute_process(COMMAND "${PKG_CONFIG}" --cflags --libs engram OUTPUT_VARIABLE flags
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${PKG_CONFIG}" --variable=libdir engram OUTPUT_VARIABLE libdir
  OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run("${CC}" -std=c11 -Wall -Wextra -Wpedantic -Werror "${PROJECT}/outside.c" -o "${WORK}/plain_c" ${flags})
run("${CXX}" -std=c++20 -Wall -Wextra -Wpedantic -Werror "${PROJECT}/outside.cc" -o "${WORK}/plain_cpp" ${flags})
set(ENV{LD_LIBRARY_PATH} "${libdir}")
run("${WORK}/plain_c")
run("${WORK}/plain_cpp")
