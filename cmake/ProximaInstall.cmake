# Installation and the package that find_package(proxima) loads.
include(CMakePackageConfigHelpers)

get_property(layers GLOBAL PROPERTY PROXIMA_LAYERS)
install(TARGETS proxima ${layers} EXPORT proximaTargets FILE_SET HEADERS)
install(EXPORT proximaTargets NAMESPACE proxima:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)
configure_package_config_file(cmake/proximaConfig.cmake.in proximaConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)
write_basic_package_version_file(proximaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/proximaConfig.cmake ${PROJECT_BINARY_DIR}/proximaConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/proxima)
