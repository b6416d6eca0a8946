# Installation, the package that find_package(proxima) loads, and its twin for pkg-config.
include(CMakePackageConfigHelpers)

if(BUILD_SHARED_LIBS)
  set(libraries proxima_shared)
else()
  get_property(libraries GLOBAL PROPERTY PROXIMA_LAYERS)
endif()
if(PROXIMA_WITH_ASSIMP AND (BUILD_SHARED_LIBS OR TARGET proxima_c OR TARGET proxima_cli))
  install(TARGETS proxima_scene_library LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/proxima COMPONENT runtime)
endif()
set(parts
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT development
  ARCHIVE COMPONENT development
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(TARGETS proxima ${libraries} EXPORT proximaTargets ${parts})
if(TARGET proxima_c)
  install(TARGETS proxima_c EXPORT proximaTargets ${parts})
endif()
install(EXPORT proximaTargets NAMESPACE proxima:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima COMPONENT development)
configure_package_config_file(cmake/proximaConfig.cmake.in proximaConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)
write_basic_package_version_file(proximaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/proximaConfig.cmake ${PROJECT_BINARY_DIR}/proximaConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima COMPONENT development)

# Static libraries: a layer comes before those it uses, and theirs follow by Requires.
set(PROXIMA_PC_REQUIRES "eigen3")
set(PROXIMA_PC_REQUIRES_PRIVATE "")
if(BUILD_SHARED_LIBS)
  set(PROXIMA_PC_LIBS "-lproxima")
else()
  set(PROXIMA_PC_LIBS "")
  foreach(layer IN LISTS libraries)
    string(PREPEND PROXIMA_PC_LIBS "-l${layer} ")
  endforeach()
  if(PROXIMA_WITH_TBB)
    string(APPEND PROXIMA_PC_REQUIRES ", tbb")
  endif()
  string(APPEND PROXIMA_PC_REQUIRES ", libhwy, libxxhash")
  if(PROXIMA_WITH_ASSIMP)
    # Layers mesh and scenes use each other.
    set(PROXIMA_PC_LIBS "-Wl,--start-group ${PROXIMA_PC_LIBS}-Wl,--end-group -Wl,--push-state,--as-needed,-lassimp,--pop-state")
    set(PROXIMA_PC_REQUIRES_PRIVATE "assimp")
  endif()
endif()
# Relative to the file itself: the installed tree may be moved.
file(RELATIVE_PATH PROXIMA_PC_PREFIX "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
cmake_path(APPEND PROXIMA_PC_INCLUDEDIR "\${prefix}" "${CMAKE_INSTALL_INCLUDEDIR}")
cmake_path(APPEND PROXIMA_PC_LIBDIR "\${prefix}" "${CMAKE_INSTALL_LIBDIR}")
configure_file(cmake/proxima.pc.in proxima.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/proxima.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
if(TARGET proxima_c)
  configure_file(cmake/proxima-c.pc.in proxima-c.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/proxima-c.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endif()
