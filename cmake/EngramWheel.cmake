# What the command in a wheel draws text and writes pictures with is linked into it, so that of
# cairo's many libraries (X11's among them) only what is used travels, and no system's own is needed.
# Other libraries, and those of the extension, are taken along by auditwheel.

# engram_link_statically(<target of cairo and libzip>)
function(engram_link_statically target)
  foreach(name cairo fontconfig freetype expat png16 pixman-1 brotlidec brotlicommon z)
    find_library(ENGRAM_ARCHIVE_${name} lib${name}.a REQUIRED)
    list(APPEND archives "${ENGRAM_ARCHIVE_${name}}")
  endforeach()
  find_library(ENGRAM_ZIP zip REQUIRED)
  set_target_properties(${target} PROPERTIES INTERFACE_LINK_LIBRARIES
    "${archives};${ENGRAM_ZIP};m")
endfunction()

# engram_run_on_older_systems(<target>): what newer C and C++ libraries have alone is replaced.
function(engram_run_on_older_systems target)
  target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/python/src/older_systems.cc")
  # Bound at the start, so that nothing can be missing later.
  target_link_options(${target} PRIVATE -Wl,--as-needed -Wl,--exclude-libs,ALL -Wl,-z,now
    -Wl,--wrap=hypot -Wl,--wrap=_ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE)
endfunction()
