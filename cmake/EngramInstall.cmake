# What is installed: components runtime (the shared library), development (headers, CMake and
# pkg-config files) and command.

install(TARGETS engram_shared EXPORT engramTargets
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT development)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/api/engram" TYPE INCLUDE COMPONENT development)
if(TARGET engram_cli)
  install(TARGETS engram_cli RUNTIME COMPONENT command)
endif()

# The rest of the CMake package: EngramTasks.cmake.
install(EXPORT engramTargets NAMESPACE engram:: DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/engram"
  COMPONENT development)

# Paths in it start from where the file itself lies, so that an installed tree can be moved.
set(engram_pc_dir "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
file(RELATIVE_PATH ENGRAM_PREFIX_FROM_PC "/${engram_pc_dir}" "/")
string(REGEX REPLACE "/$" "" ENGRAM_PREFIX_FROM_PC "${ENGRAM_PREFIX_FROM_PC}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/engram.pc.in" "${PROJECT_BINARY_DIR}/install/engram.pc"
  @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/install/engram.pc" DESTINATION "${engram_pc_dir}"
  COMPONENT development)
