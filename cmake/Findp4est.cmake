# p4est (Debian: libp4est-dev) and its support library sc, as p4est::p4est. It has neither pkg-config nor a configuration
# file. Needs the language C, for MPI::MPI_C.
find_package(MPI QUIET COMPONENTS C)
find_path(p4est_INCLUDE_DIR p8est.h)
find_library(p4est_LIBRARY p4est)
find_library(p4est_sc_LIBRARY sc)
mark_as_advanced(p4est_INCLUDE_DIR p4est_LIBRARY p4est_sc_LIBRARY)
if(p4est_INCLUDE_DIR AND EXISTS "${p4est_INCLUDE_DIR}/p4est_config.h")
  file(STRINGS "${p4est_INCLUDE_DIR}/p4est_config.h" version_line REGEX "#define P4EST_VERSION \"")
  string(REGEX REPLACE ".*\"([^\"]+)\".*" "\\1" p4est_VERSION "${version_line}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(p4est
  REQUIRED_VARS p4est_LIBRARY p4est_sc_LIBRARY p4est_INCLUDE_DIR MPI_C_FOUND VERSION_VAR p4est_VERSION)
if(p4est_FOUND AND NOT TARGET p4est::p4est)
  add_library(p4est::p4est UNKNOWN IMPORTED)
  # Without the bindings for C++ that Open MPI's header would want to link.
  set_target_properties(p4est::p4est PROPERTIES IMPORTED_LOCATION "${p4est_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${p4est_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS "OMPI_SKIP_MPICXX;MPICH_SKIP_MPICXX"
    INTERFACE_LINK_LIBRARIES "${p4est_sc_LIBRARY};MPI::MPI_C")
endif()
