# Films by libav: a module that is loaded when the first one begins.

pkg_check_modules(ENGRAM_LIBAV REQUIRED IMPORTED_TARGET
  libavcodec libavformat libavutil libswscale)
add_library(engram_video MODULE "${PROJECT_SOURCE_DIR}/media/libav/libav_stream.cc")
engram_configure_cold_target(engram_video)
target_link_libraries(engram_video PRIVATE PkgConfig::ENGRAM_LIBAV)
add_dependencies(engram_media engram_video)
if(ENGRAM_INSTALL)
  install(TARGETS engram_video LIBRARY DESTINATION lib/engram COMPONENT command)
endif()
