# Configures a project that has Proxima by add_subdirectory: it must see no internal headers and install nothing of Proxima.
#
#     cmake -DPROXIMA=<sources> -DWORK=<folder to use> -DCXX=<compiler> -P subproject_test.cmake
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${WORK})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK} -G Ninja -DCMAKE_CXX_COMPILER=${CXX} -DPROXIMA=${PROXIMA}
  COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(READ ${WORK}/include_folders.txt folders)
if(NOT "${PROXIMA}/include" IN_LIST folders OR "${PROXIMA}/src" IN_LIST folders)
  message(FATAL_ERROR "include folders of a user's program: ${folders}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --install ${WORK} --prefix ${WORK}/prefix COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(GLOB_RECURSE installed ${WORK}/prefix/*)
if(installed)
  message(FATAL_ERROR "installed: ${installed}")
endif()
