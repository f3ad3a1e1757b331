# Several processes under mpirun: a module that is loaded only then, so that nothing else needs MPI.

set(MPI_CXX_SKIP_MPICXX ON)  # the C interface alone; the C++ one would be another library
find_package(MPI COMPONENTS CXX)
option(ENGRAM_BUILD_MPI "Build what lets `mpirun engram` share work" ${MPI_CXX_FOUND})
if(ENGRAM_BUILD_MPI)
  find_package(MPI REQUIRED COMPONENTS CXX)
  add_library(engram_mpi MODULE "${PROJECT_SOURCE_DIR}/protocol/parallel/mpi/mpi_ranks.cc")
  engram_configure_target(engram_mpi)
  target_compile_definitions(engram_mpi PRIVATE ${MPI_CXX_COMPILE_DEFINITIONS})
  target_include_directories(engram_mpi SYSTEM PRIVATE ${MPI_CXX_INCLUDE_DIRS})
  target_link_libraries(engram_mpi PRIVATE ${MPI_CXX_LIBRARIES})
  if(TARGET engram_cli)
    add_dependencies(engram_cli engram_mpi)
  endif()
  if(ENGRAM_INSTALL)
    install(TARGETS engram_mpi LIBRARY DESTINATION lib/engram COMPONENT mpi)
  endif()
endif()
