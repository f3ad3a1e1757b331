# The shared library, which is what is installed.

include(GNUInstallDirs)

set(ENGRAM_SOVERSION 0)  # grows when engram_c.h changes what old programs rely on
add_library(engram_shared SHARED)
target_link_libraries(engram_shared PRIVATE engram_objects engram_cold_objects)
target_include_directories(engram_shared INTERFACE
  "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/api>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
target_compile_features(engram_shared INTERFACE cxx_std_20)
set(engram_symbols "${CMAKE_CURRENT_LIST_DIR}/engram.symbols")
target_link_options(engram_shared PRIVATE
  "-Wl,--version-script=${engram_symbols}" -Wl,--as-needed)
set_target_properties(engram_shared PROPERTIES
  LINK_DEPENDS "${engram_symbols}" LINKER_LANGUAGE CXX
  OUTPUT_NAME engram EXPORT_NAME engram
  VERSION ${PROJECT_VERSION} SOVERSION ${ENGRAM_SOVERSION})
