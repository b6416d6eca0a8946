# Installs into an empty prefix, then builds and runs separate projects against it, by find_package
# and by pkg-config: a small one, and the examples. Before that, looks at what was installed, and
# compiles all headers in one source (installed_headers.py). The libraries may be static or shared.
#
#     cmake -DBUILD=<build folder> -DWORK=<folder to use> -DCXX=<compiler> -DLIBDIR=<lib> -DPYTHON=<python>
#       -DCTEST=<ctest> -DREADS_SCENES=<with assimp> -P install_test.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${command}\nstatus ${status}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect_answer program)
  run(${program})
  if(NOT output STREQUAL "12 6 160 5\n")
    message(FATAL_ERROR "${program} printed: ${output}")
  endif()
  # It reads no mesh from a file. What it links itself stays, used or not.
  run(readelf -d ${program})
  if(NOT output MATCHES "libatomic")
    message(FATAL_ERROR "${program} has lost libatomic:\n${output}")
  endif()
  if(output MATCHES "assimp")
    message(FATAL_ERROR "${program} needs assimp:\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

# The program opens its libraries where they are installed.
set(scene ${CMAKE_CURRENT_LIST_DIR}/../../../fuzz/corpus/glb/two_tetrahedra.glb)
if(EXISTS ${WORK}/prefix/bin/proxima)
  run(${WORK}/prefix/bin/proxima octree cube --quiet --picture ${WORK}/cube.png)
  if(READS_SCENES)
    run(${WORK}/prefix/bin/proxima check ${scene})
  endif()
endif()

set(ENV{PKG_CONFIG_PATH} ${WORK}/prefix/${LIBDIR}/pkgconfig)
run(pkg-config --cflags proxima)
separate_arguments(flags UNIX_COMMAND "${output}")
run(${PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/installed_headers.py ${WORK}/prefix/include ${CXX} ${flags})

run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G Ninja -DCMAKE_CXX_COMPILER=${CXX}
  -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK}/build)
expect_answer(${WORK}/build/uses_proxima)

# Static libraries need xxHash, and a project that can do without Proxima goes on.
if(EXISTS ${WORK}/prefix/${LIBDIR}/libproxima_base.a)
  set(ENV{PKG_CONFIG_LIBDIR} ${WORK})
  set(ENV{PKG_CONFIG_PATH} "")
  run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/without_xxhash -G Ninja -DCMAKE_CXX_COMPILER=${CXX}
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DLOOKS_ONLY=ON)
  if(NOT output MATCHES "found: (FALSE|0), pkg-config does not find libxxhash")
    message(FATAL_ERROR "without xxHash: ${output}")
  endif()
  unset(ENV{PKG_CONFIG_LIBDIR})
  set(ENV{PKG_CONFIG_PATH} ${WORK}/prefix/${LIBDIR}/pkgconfig)
endif()

# The examples as a project of its own. Of C++ one is built: the suite runs them all, built with the library.
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/../../../examples -B ${WORK}/examples -G Ninja
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_BUILD_TYPE=None)
run(${CMAKE_COMMAND} --build ${WORK}/examples --target what_is_closest rays_in_c)
run(${CTEST} --test-dir ${WORK}/examples --no-tests=error --output-on-failure -R "what_is_closest|rays_in_c")
if(READS_SCENES)
  run(${PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/../../c/ctypes_test.py ${WORK}/prefix/${LIBDIR}/libproxima_c.so ${scene})
  run(${WORK}/examples/what_is_closest ${scene})
  if(NOT output MATCHES "^closest point ")
    message(FATAL_ERROR "what_is_closest printed: ${output}")
  endif()
endif()

run(pkg-config --cflags --libs proxima)
separate_arguments(flags UNIX_COMMAND "${output}")
run(${CXX} -Wl,--no-as-needed ${CMAKE_CURRENT_LIST_DIR}/main.cpp -o ${WORK}/by_pkg_config ${flags} -latomic)
set(ENV{LD_LIBRARY_PATH} ${WORK}/prefix/${LIBDIR})
expect_answer(${WORK}/by_pkg_config)
