# Debian packages, by CPack: each holds one component of the installation. scripts/package builds them.
#
#     libproxima0.1     the shared libraries for C++ and C
#     libproxima-dev    headers, and what CMake and pkg-config read
#     proxima-tools     the program, its manual pages and completion
#     python3-proxima   the Python module
#     proxima-doc       the pages of docs
if(NOT PROXIMA_INSTALL OR NOT BUILD_SHARED_LIBS OR NOT PROXIMA_BUILD_APPS OR NOT PROXIMA_BUILD_C OR NOT TARGET proxima_python)
  message(FATAL_ERROR "packages need PROXIMA_INSTALL, BUILD_SHARED_LIBS, PROXIMA_BUILD_APPS, PROXIMA_BUILD_C and PROXIMA_BUILD_PYTHON")
endif()
find_program(PROXIMA_GZIP gzip REQUIRED)
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
set(PROXIMA_MAINTAINER "The Proxima authors <proxima@proxima.invalid>" CACHE STRING "Who built the packages, with an address")
set(work ${PROJECT_BINARY_DIR}/packages)

# The manual pages and the completion, from the program's own help.
set(manual ${work}/manual)
set(made ${manual}/proxima.bash ${manual}/_proxima ${manual}/proxima.fish)
add_custom_command(OUTPUT ${made}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual}
  COMMAND Python3::Interpreter -B ${PROJECT_SOURCE_DIR}/scripts/manual.py $<TARGET_FILE:proxima_cli> ${manual}
  COMMAND ${PROXIMA_GZIP} -9nr --suffix .gz ${manual}
  COMMAND ${PROXIMA_GZIP} -d ${manual}/proxima.bash.gz ${manual}/_proxima.gz ${manual}/proxima.fish.gz
  DEPENDS proxima_cli ${PROJECT_SOURCE_DIR}/scripts/manual.py ${PROJECT_SOURCE_DIR}/scripts/option_table.py
  VERBATIM)
add_custom_target(proxima_manual ALL DEPENDS ${made})
install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools FILES_MATCHING PATTERN "*.1.gz")
install(FILES ${manual}/proxima.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME proxima COMPONENT tools)
install(FILES ${manual}/_proxima DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT tools)
install(FILES ${manual}/proxima.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT tools)

install(FILES README.md CHANGELOG.md CONTRIBUTING.md LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/proxima-doc COMPONENT doc)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/proxima-doc COMPONENT doc PATTERN site EXCLUDE)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/proxima-doc COMPONENT doc PATTERN CMakeLists.txt EXCLUDE PATTERN __pycache__ EXCLUDE)

# What each package has in its folder of documents.
file(READ LICENSE license)
string(REGEX REPLACE "^MIT License\n\nCopyright \\(c\\) ([^\n]*)\n\n" "" license "${license}")
set(holders "${CMAKE_MATCH_1}")
if(NOT holders)
  message(FATAL_ERROR "LICENSE does not begin with \"MIT License\" and a line \"Copyright (c)\": the packages name who holds the copyright")
endif()
string(REPLACE "\n\n" "\n.\n" license "${license}")
string(REGEX REPLACE "\n([^\n])" "\n \\1" license "${license}")
file(WRITE ${work}/copyright
  "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: Proxima\n"
  "Comment: Pictures of a bunny show the Stanford Bunny, courtesy of the Stanford Computer Graphics Laboratory.\n\n"
  "Files: *\nCopyright: ${holders}\nLicense: Expat\n ${license}")
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${work}/changelog.Debian
  "proxima (${PROJECT_VERSION}-1) unstable; urgency=medium\n\n  * What is new is in CHANGELOG.md of the sources.\n\n"
  " -- ${PROXIMA_MAINTAINER}  ${now}\n")
execute_process(COMMAND ${PROXIMA_GZIP} -9nf ${work}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME proxima)
set(CPACK_PACKAGE_VENDOR Proxima)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "spatial queries on triangle meshes")
set(CPACK_PACKAGE_CONTACT "${PROXIMA_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${work})
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SOURCE proxima)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENTS_ALL)

# proxima_package(COMPONENT NAME SECTION DEPENDS DESCRIPTION)
function(proxima_package component name section depends description)
  install(FILES ${work}/copyright ${work}/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${description}" PARENT_SCOPE)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()

set(what "Proxima finds closest features, signed distances, what rays hit, where meshes\nmeet and what a camera sees, and computes forces of touch, on triangle meshes.\n\n")
string(REGEX MATCH "^([0-9]+)\\.([0-9]+)" PROXIMA_PYTHON_VERSION ${PROXIMA_PYTHON_VERSION})
math(EXPR next_python "${CMAKE_MATCH_2} + 1")
string(PREPEND next_python "${CMAKE_MATCH_1}.")
set(same "(= ${PROJECT_VERSION}-1)")
set(runtime libproxima${PROXIMA_SOVERSION})
proxima_package(runtime ${runtime} libs ""
  "${what}This package has the shared libraries for programs in C++ and C.")
proxima_package(development libproxima-dev libdevel "${runtime} ${same}, libeigen3-dev, libexpected-dev"
  "${what}This package has the headers, and what CMake and pkg-config need to find it.")
proxima_package(tools proxima-tools science "${runtime} ${same}"
  "${what}This package has the program proxima, which asks these questions of files.")
proxima_package(python python3-proxima python "python3 (>= ${PROXIMA_PYTHON_VERSION}), python3 (<< ${next_python}), python3-numpy"
  "${what}This package has the Python module proxima, which answers for NumPy arrays.")
proxima_package(doc proxima-doc doc ""
  "${what}This package has the pages and examples of the project.")
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SUGGESTS proxima-doc)

# Which versions programs need that are linked with the libraries, and the cache of libraries made anew.
file(WRITE ${work}/shlibs "libproxima ${PROXIMA_SOVERSION} ${runtime} (>= ${PROJECT_VERSION})\nlibproxima_c 1 ${runtime} (>= ${PROJECT_VERSION})\n")
file(WRITE ${work}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${work}/shlibs ${work}/triggers)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# Python's modules are compiled when the package is installed, and these files removed with it.
file(WRITE ${work}/postinst "#!/bin/sh\nset -e\nif [ \"$1\" = configure ] && command -v py3compile >/dev/null; then\n  py3compile -p python3-proxima\nfi\n")
file(WRITE ${work}/prerm "#!/bin/sh\nset -e\nif command -v py3clean >/dev/null; then\n  py3clean -p python3-proxima\nfi\n")
file(CHMOD ${work}/postinst ${work}/prerm PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${work}/postinst ${work}/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
