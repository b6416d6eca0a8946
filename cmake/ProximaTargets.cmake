# How every target of the house is made: language level, warnings, sanitizers, layers.

# Compile options and internal headers of our own code; never passed on to users.
add_library(proxima_developer_options INTERFACE)
target_include_directories(proxima_developer_options INTERFACE ${PROJECT_SOURCE_DIR}/src)
# No fused multiply-add: decisions must have the same bits on every instruction set. No errno from square roots:
# it takes a branch and a call beside each of them.
target_compile_options(proxima_developer_options INTERFACE
  -ffp-contract=off -fno-math-errno -Wall -Wextra -Wconversion -Wshadow -Wno-sign-conversion
  $<$<BOOL:${PROXIMA_WARNINGS_AS_ERRORS}>:-Werror>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND PROXIMA_WARNINGS_AS_ERRORS)
  # It collects garbage from a gigabyte on: a twelfth less time, a quarter more memory.
  target_compile_options(proxima_developer_options INTERFACE --param=ggc-min-heapsize=1000000)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  # Otherwise g++ 12 copies and clears structs of a hundred bytes by `rep movs` and `rep stos` in code for AVX2 and SSE4.
  # These take dozens of cycles to begin.
  foreach(job memcpy memset)
    target_compile_options(proxima_developer_options INTERFACE
      -m${job}-strategy=unrolled_loop:1024:noalign,libcall:-1:noalign)
  endforeach()
endif()
# A section for each function, so that libraries of a few of them leave out the others.
target_compile_options(proxima_developer_options INTERFACE -ffunction-sections -fdata-sections)
if(NOT PROXIMA_SANITIZE)
  # What is installed notices an overwritten stack, and copies that do not fit where sizes are known (docs/security.md).
  target_compile_options(proxima_developer_options INTERFACE $<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-fstack-protector-strong>)
  # Unless the flags say how much is checked: distributions set 3.
  string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
  if(NOT "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}" MATCHES "_FORTIFY_SOURCE")
    target_compile_options(proxima_developer_options INTERFACE
      "$<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>")
  endif()
endif()
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
  # Highway's NEON includes the instructions for AES, and g++ gives only some of a kernel's functions what it asks for. No
  # code of ours uses them, so processors without AES are served, too.
  target_compile_options(proxima_developer_options INTERFACE -march=armv8-a+crypto)
  # Eigen fuses multiplications and additions where it sees this, and answers of contacts then have other bits than on x86.
  target_compile_options(proxima_developer_options INTERFACE -U__ARM_FEATURE_FMA)
endif()
if(PROXIMA_SANITIZE)
  # Without the check that pointers do not wrap: it makes exits of loops, on which clang 14 spends half of its time in kernels. And
  # without those, before each use of a pointer, that it is not null and that an object of the type and size lies there: they
  # take another quarter. What is read or written by such pointers outside of objects, the address sanitizer sees.
  target_compile_options(proxima_developer_options INTERFACE
    -fsanitize=${PROXIMA_SANITIZE} -fno-sanitize=pointer-overflow,null,object-size,vptr -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(proxima_developer_options INTERFACE -fsanitize=${PROXIMA_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    # No search for where variables are, which takes up to a tenth of the time: -g1 does not name them.
    target_compile_options(proxima_developer_options INTERFACE "SHELL:-mllvm -experimental-debug-variable-locations=false")
    # A program of a hundred megabytes is linked in 2 s, not 10.
    find_program(PROXIMA_LLD ld.lld-14)
    mark_as_advanced(PROXIMA_LLD)
    if(PROXIMA_LLD)
      target_link_options(proxima_developer_options INTERFACE -fuse-ld=lld)
    endif()
  endif()
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    # Kernels for AVX2 and AVX-512 only: watched, the emulated lanes of older processors take hours to compile.
    # Eigen is not to fuse multiplications and additions: contacts then have other bits than in other builds.
    target_compile_options(proxima_developer_options INTERFACE -march=x86-64-v3 -U__FMA__)
    target_compile_definitions(proxima_developer_options INTERFACE HWY_BASELINE_TARGETS=HWY_AVX2)
  endif()
endif()

# Headers that many files of a target share; sources include what they use all the same. Not for headers of
# many templates: these are instantiated anew in every source that loads them.
function(proxima_precompile target)
  if(PROXIMA_PRECOMPILE_HEADERS)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# Objects that a shared library may take: position-independent, and exporting only what says so (proxima/export.h).
function(proxima_fit_for_shared_libraries target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# Of a shared library or module: exports what a version script says. It stays loaded, and oneTBB with it, when a program
# closes it: oneTBB's threads outlive the work that they were given.
function(proxima_export_by target script)
  target_link_options(${target} PRIVATE LINKER:--version-script=${script} LINKER:-z,relro,-z,now,-z,nodelete)
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${script})
endfunction()

# The same for all position-independent targets that see Eigen: the geometry layer compiles these headers for
# itself and for those after it.
function(proxima_share_headers target)
  if(target STREQUAL "proxima_geometry")
    proxima_precompile(${target} <Eigen/Core> <algorithm> <string> <vector>)
  elseif(PROXIMA_PRECOMPILE_HEADERS)
    target_precompile_headers(${target} REUSE_FROM proxima_geometry)
  endif()
  proxima_fit_for_shared_libraries(${target})
endfunction()

# Optimised little: for code that runs once, much of it other libraries' templates. g++ takes the level of
# optimisation from precompiled headers, whatever the command says, so joined sources go without them.
function(proxima_build_quickly target)
  if(PROXIMA_SANITIZE)
    # The alignment of addresses is not checked either: this code maps no files.
    target_compile_options(${target} PRIVATE -O0 -fno-sanitize=alignment)
  else()
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
  set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS "${CMAKE_UNITY_BUILD}")
endfunction()

# For fuzzers, of kernels and of layers that read no files: what they compare are computed numbers, which no fuzzer can put
# into its input, and exact arithmetic took half as long again for it.
set(PROXIMA_UNTRACED -fno-sanitize-coverage=trace-cmp)
function(proxima_trace_files_only target layer)
  if(PROXIMA_SANITIZE MATCHES "fuzzer" AND layer MATCHES "_(geometry|minkowski|query)$")
    target_compile_options(${target} PRIVATE ${PROXIMA_UNTRACED})
  endif()
endfunction()

# Of a program in C that loads a library of ours: sanitizers are a part of the program.
function(proxima_link_sanitizers target)
  if(PROXIMA_SANITIZE)
    set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
    target_link_options(${target} PRIVATE -fsanitize=${PROXIMA_SANITIZE})
  endif()
endfunction()

# Sources that Highway compiles once for every instruction set: each is a unit of its own in whole builds
# that join sources (CMAKE_UNITY_BUILD). On x86 these are AVX-512, AVX2, SSE4 and no lanes, which is what the few
# processors with SSSE3 and without SSE4 get, too. On Arm it is NEON: lanes of SVE cannot lie in arrays, as kernels keep theirs.
# What comes after UP_TO_AVX2 gains next to nothing from AVX-512 and goes without; what comes after AVX2_ALONE goes
# without SSE4, too, which keeps the library small.
function(proxima_own_units)
  cmake_parse_arguments(ARG "" "" "UP_TO_AVX2;AVX2_ALONE" ${ARGN})
  set(unused HWY_SSSE3)
  if(PROXIMA_SANITIZE MATCHES "fuzzer")
    # Functions of more than 200 accesses call the address sanitizer, which takes half of the time to compile.
    set_property(SOURCE ${ARG_UNPARSED_ARGUMENTS} ${ARG_UP_TO_AVX2} ${ARG_AVX2_ALONE} APPEND PROPERTY COMPILE_OPTIONS
      ${PROXIMA_UNTRACED} -mllvm -asan-instrumentation-with-call-threshold=200)
  endif()
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
    set(unused "(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")
  endif()
  set_source_files_properties(${ARG_UNPARSED_ARGUMENTS} ${ARG_UP_TO_AVX2} ${ARG_AVX2_ALONE} PROPERTIES
    SKIP_UNITY_BUILD_INCLUSION ON COMPILE_DEFINITIONS "HWY_DISABLED_TARGETS=${unused}")
  foreach(source IN LISTS ARG_UP_TO_AVX2)
    set_source_files_properties(${source} PROPERTIES COMPILE_DEFINITIONS "HWY_DISABLED_TARGETS=(${unused}|HWY_AVX3)")
  endforeach()
  foreach(source IN LISTS ARG_AVX2_ALONE)
    set_source_files_properties(${source} PROPERTIES COMPILE_DEFINITIONS
      "HWY_DISABLED_TARGETS=(${unused}|HWY_SSE4|HWY_AVX3)")
  endforeach()
endfunction()

# Objects of a layer at a level of optimisation of their own. Without precompiled headers, from which g++ would take the
# level. Where it inlines little, g++ 12 warns of members that a constructor sets.
function(proxima_add_objects layer objects level sources links)
  add_library(${objects} OBJECT ${sources})
  target_compile_options(${objects} PRIVATE $<$<CONFIG:Release>:${level}> $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_compile_features(${objects} PRIVATE cxx_std_20)
  target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR}/include)
  target_link_libraries(${objects} PRIVATE ${links} proxima_developer_options)
  proxima_fit_for_shared_libraries(${objects})
  proxima_trace_files_only(${objects} ${layer})
  target_sources(${layer} PRIVATE $<TARGET_OBJECTS:${objects}>)
endfunction()

# proxima_add_layer(NAME PUBLIC_HEADERS ... HEADERS ... SOURCES ... COMPACT_SOURCES ... SMALL_SOURCES ... LINK ... PRIVATE_LINK ...)
# One static library per layer: target proxima_NAME, proxima::NAME for users of static libraries. Public headers lie
# in include/proxima and are installed; the others are for the project itself. Compact sources are those that were
# measured to be no slower at -O2, which makes a fifth less code of them. Small sources are compiled for size: what
# runs once per file, mesh or session, such as checks. No query may be among them.
function(proxima_add_layer name)
  cmake_parse_arguments(ARG "" "" "PUBLIC_HEADERS;HEADERS;SOURCES;COMPACT_SOURCES;SMALL_SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  set(target proxima_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  if(ARG_COMPACT_SOURCES)
    proxima_add_objects(${target} ${target}_compact -O2 "${ARG_COMPACT_SOURCES}" "${ARG_LINK};${ARG_PRIVATE_LINK}")
  endif()
  if(ARG_SMALL_SOURCES)
    proxima_add_objects(${target} ${target}_small -Os "${ARG_SMALL_SOURCES}" "${ARG_LINK};${ARG_PRIVATE_LINK}")
  endif()
  add_library(proxima::${name} ALIAS ${target})
  list(TRANSFORM ARG_PUBLIC_HEADERS PREPEND ${PROJECT_SOURCE_DIR}/include/proxima/)
  target_sources(${target} PUBLIC FILE_SET HEADERS
    BASE_DIRS ${PROJECT_SOURCE_DIR}/include FILES ${ARG_PUBLIC_HEADERS})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/include)
  target_link_libraries(${target} PUBLIC ${ARG_LINK}
    PRIVATE ${ARG_PRIVATE_LINK} $<BUILD_INTERFACE:proxima_developer_options>)
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  proxima_trace_files_only(${target} ${target})
  if(name STREQUAL "base")
    proxima_fit_for_shared_libraries(${target})
  else()
    proxima_share_headers(${target})
  endif()
  set_property(GLOBAL APPEND PROPERTY PROXIMA_LAYERS ${target})
  if(ARG_PUBLIC_HEADERS) # for the shared library
    set_property(GLOBAL APPEND PROPERTY PROXIMA_PUBLIC_HEADERS ${ARG_PUBLIC_HEADERS})
    list(FILTER ARG_LINK EXCLUDE REGEX "^proxima::")
    set_property(GLOBAL APPEND PROPERTY PROXIMA_LINKS ${ARG_LINK})
    set_property(GLOBAL APPEND PROPERTY PROXIMA_PRIVATE_LINKS ${ARG_PRIVATE_LINK})
  endif()

  # The internal headers, each compiled alone by the build preset `headers` like the public ones.
  add_library(${target}_internal INTERFACE)
  target_sources(${target}_internal INTERFACE FILE_SET HEADERS
    BASE_DIRS ${PROJECT_SOURCE_DIR}/src FILES ${ARG_HEADERS})
  target_link_libraries(${target}_internal INTERFACE ${target})
endfunction()
