# cmake -DBUILD=<build folder> -DTASK_PAGE=<docs/cpp_tasks.md> -DCOMMAND=<python/engram/command>
#       -DENGRAM=<the command> -DWORK=<folder of its own> -DCXX=... -DPYTHON=...
#       -P check_wheel_package.cmake
# Installs what wheels have for libraries of tasks, finds it as `python -m engram --cmake-dir` does,
# and builds and runs a user's task with it.

macro(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endmacro()

file(REMOVE_RECURSE "${WORK}")
run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/first" --component wheel)
file(RENAME "${WORK}/first" "${WORK}/site")
file(COPY "${COMMAND}" DESTINATION "${WORK}/site/engram")

execute_process(COMMAND "${PYTHON}" -c
  "import sys; sys.path.insert(0, 'engram'); sys.argv[1:] = ['--cmake-dir']; import command; command.main()"
  WORKING_DIRECTORY "${WORK}/site" OUTPUT_VARIABLE folder OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)

run("${CMAKE_COMMAND}" "-DPAGE=${TASK_PAGE}" "-DFOLDER=${WORK}/tasks"
  -P "${CMAKE_CURRENT_LIST_DIR}/page_tasks.cmake")
run("${CMAKE_COMMAND}" -S "${WORK}/tasks" -B "${WORK}/tasks/build" "-Dengram_DIR=${folder}"
  "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror")
run("${CMAKE_COMMAND}" --build "${WORK}/tasks/build")
run("${ENGRAM}" --tasks "${WORK}/tasks/build/libtouch_spot.so" eval TouchSpot-VLA-v0
  --policy oracle --episodes 32 --out "${WORK}/results")
