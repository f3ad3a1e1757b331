# What is installed: components runtime (the shared library), development (headers, CMake and
# pkg-config files) and command.

include(CMakePackageConfigHelpers)

install(TARGETS engram_shared EXPORT engramTargets
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT development)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/api/engram" TYPE INCLUDE COMPONENT development)
if(TARGET engram_cli)
  install(TARGETS engram_cli RUNTIME COMPONENT command)
endif()

set(engram_cmake_dir "${CMAKE_INSTALL_LIBDIR}/cmake/engram")
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/engramConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/install/engramConfig.cmake" INSTALL_DESTINATION "${engram_cmake_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/install/engramConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/install/engramConfig.cmake"
  "${PROJECT_BINARY_DIR}/install/engramConfigVersion.cmake"
  "${CMAKE_CURRENT_LIST_DIR}/EngramAddTasks.cmake"
  DESTINATION "${engram_cmake_dir}" COMPONENT development)
foreach(export engramTargets engramTasksTargets)
  install(EXPORT ${export} NAMESPACE engram:: DESTINATION "${engram_cmake_dir}"
    COMPONENT development)
endforeach()

# Paths in it start from where the file itself lies, so that an installed tree can be moved.
set(engram_pc_dir "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
file(RELATIVE_PATH ENGRAM_PREFIX_FROM_PC "/${engram_pc_dir}" "/")
string(REGEX REPLACE "/$" "" ENGRAM_PREFIX_FROM_PC "${ENGRAM_PREFIX_FROM_PC}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/engram.pc.in" "${PROJECT_BINARY_DIR}/install/engram.pc"
  @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/install/engram.pc" DESTINATION "${engram_pc_dir}"
  COMPONENT development)
