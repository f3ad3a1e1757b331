# Debian packages, one for each component of the installation: `cpack` in a build folder that was
# configured with -DCMAKE_INSTALL_PREFIX=/usr, which scripts/package.sh does.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME engram)
set(CPACK_PACKAGE_VENDOR engram)
# CPack would put any other summary in front of the synopses below.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${CMAKE_PROJECT_NAME} built using CMake")
set(CPACK_PACKAGE_CONTACT "The engram authors")
set(CPACK_PACKAGING_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # dependencies from what the programs are linked with

# engram_package(<component> <package> <section> <synopsis> <description>)
macro(engram_package component package section synopsis description)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${synopsis}\n${description}")
  install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/doc/${package}"
    RENAME copyright COMPONENT ${component})
endmacro()

set(CPACK_COMPONENTS_ALL "")
set(engram_about "engram steps hundreds of environments of the MIKASA-Robo-VLA memory tasks (a Franka\nPanda at a table) in lockstep, with physics by MuJoCo and pictures by a ray caster.")

engram_package(runtime libengram${ENGRAM_SOVERSION} libs
  "batched simulation of tabletop memory tasks (library)" "${engram_about}")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_GENERATE_SHLIBS ON)
# Opened at run time, for pictures that OpenGL draws.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "libegl1, libegl-mesa0, libgl1-mesa-dri")

engram_package(development libengram-dev libdevel
  "batched simulation of tabletop memory tasks (development files)"
  "${engram_about}\nThis package holds the headers for C and C++, what libraries of tasks are made of, and\nfiles for CMake and pkg-config.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libengram${ENGRAM_SOVERSION} (= ${PROJECT_VERSION})")
# For libraries of tasks alone.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "libeigen3-dev (>= 3.4), libtinyxml2-dev")

if(TARGET engram_cli)
  engram_package(command engram science
    "batched simulation of tabletop memory tasks (command)"
    "${engram_about}\nThis package holds the command: rollouts, evaluations, videos, benchmarks.")
  set(CPACK_DEBIAN_COMMAND_PACKAGE_SUGGESTS "libegl1, libegl-mesa0, libgl1-mesa-dri")
endif()

if(TARGET engram_mpi)
  engram_package(mpi engram-mpi science
    "batched simulation of tabletop memory tasks (several machines)"
    "${engram_about}\nThis package lets the command share its work under mpirun.")
endif()

if(ENGRAM_BUILD_PYTHON)
  engram_package(python python3-engram python
    "batched simulation of tabletop memory tasks (Python)"
    "${engram_about}\nThis package holds the Python module. Gymnasium, which it needs, is not part of Debian 12:\ninstall it with pip into an environment that sees the system's packages.")
  # The module is built for one version of Python.
  find_package(Python 3.9 REQUIRED COMPONENTS Interpreter)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${CMAKE_CURRENT_LIST_DIR}/debian/python/prerm")
endif()

include(CPack)
