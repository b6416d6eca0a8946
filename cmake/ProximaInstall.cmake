# Installation, the package that find_package(proxima) loads, and its twin for pkg-config.
include(CMakePackageConfigHelpers)

get_property(layers GLOBAL PROPERTY PROXIMA_LAYERS)
install(TARGETS proxima ${layers} EXPORT proximaTargets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(TARGET proxima_c)
  install(TARGETS proxima_c EXPORT proximaTargets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endif()
install(EXPORT proximaTargets NAMESPACE proxima:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)
configure_package_config_file(cmake/proximaConfig.cmake.in proximaConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)
write_basic_package_version_file(proximaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/proximaConfig.cmake ${PROJECT_BINARY_DIR}/proximaConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)

# The libraries are static: a layer comes before those it uses, and theirs follow by Requires.
set(PROXIMA_PC_LIBS "")
foreach(layer IN LISTS layers)
  get_target_property(type ${layer} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    string(PREPEND PROXIMA_PC_LIBS "-l${layer} ")
  endif()
endforeach()
set(PROXIMA_PC_REQUIRES "eigen3, tbb, libhwy, libxxhash")
if(PROXIMA_WITH_ASSIMP)
  string(APPEND PROXIMA_PC_REQUIRES ", assimp")
endif()
# Relative to the file itself: the installed tree may be moved.
file(RELATIVE_PATH PROXIMA_PC_PREFIX "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
cmake_path(APPEND PROXIMA_PC_INCLUDEDIR "\${prefix}" "${CMAKE_INSTALL_INCLUDEDIR}")
cmake_path(APPEND PROXIMA_PC_LIBDIR "\${prefix}" "${CMAKE_INSTALL_LIBDIR}")
configure_file(cmake/proxima.pc.in proxima.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/proxima.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
if(TARGET proxima_c)
  configure_file(cmake/proxima-c.pc.in proxima-c.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/proxima-c.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()
