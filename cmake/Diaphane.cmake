# Settings of all targets (language standard, warnings, ccache, sanitizers), and functions that keep the CMakeLists.txt
# of each folder short.
include_guard(GLOBAL)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()
# Line tables are enough for backtraces and halve the size of objects (Boost, gRPC and VTK are heavy).
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1 -DNDEBUG")
# By default, GCC collects garbage at 128 MB and above, which costs 10% of the time. There is enough memory for more
# (tools/devtool/build.py).
add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-expand=300>
                    $<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=1000000>)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

find_program(DIAPHANE_CCACHE ccache)
if(DIAPHANE_CCACHE)
  # Paths are relative to the checkout, so that clones and build directories share cached results. Precompiled headers need
  # the sloppiness (ccache's manual, "Precompiled headers").
  set(_environment ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
      "CCACHE_IGNOREOPTIONS=--param=ggc-* -Wno-subobject-linkage"
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime)
  # Without a cached result, ccache would preprocess each file before it is compiled, which costs 8%. Depend mode
  # takes the headers from the compiler instead. ccache does not offer it for nvcc.
  set(CMAKE_C_COMPILER_LAUNCHER ${_environment} CCACHE_DEPEND=1 ${DIAPHANE_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${_environment} CCACHE_DEPEND=1 ${DIAPHANE_CCACHE})
  # Each checkout installs its own nvcc, so it is compared by its contents instead of its date.
  set(CMAKE_CUDA_COMPILER_LAUNCHER ${_environment} CCACHE_COMPILERCHECK=content ${DIAPHANE_CCACHE})
endif()

set(DIAPHANE_SANITIZE "" CACHE STRING "address;undefined | thread | what preset fuzz says")
if(DIAPHANE_SANITIZE)
  string(REPLACE ";" "," _sanitizers "${DIAPHANE_SANITIZE}")
  add_compile_options($<$<COMPILE_LANGUAGE:C,CXX>:-fsanitize=${_sanitizers}>
                      $<$<COMPILE_LANGUAGE:C,CXX>:-fno-omit-frame-pointer>)
  add_link_options(-fsanitize=${_sanitizers})
endif()

find_package(Threads REQUIRED)

# diaphane_library(<name> SOURCES ... [PUBLIC libs...] [PRIVATE libs...] [SEPARATE] [BATCH n] [ALONE sources...])
# With DIAPHANE_UNITY, BATCH sources (by default 8) are one compilation, except those in ALONE, or all with SEPARATE.
function(diaphane_library name)
  cmake_parse_arguments(A "SEPARATE" "BATCH" "SOURCES;PUBLIC;PRIVATE;ALONE" ${ARGN})
  if(A_SOURCES)
    add_library(${name} STATIC ${A_SOURCES})
    if(DIAPHANE_UNITY AND NOT A_SEPARATE)
      if(NOT A_BATCH)
        set(A_BATCH 8)
      endif()
      # Relative paths, so that checkouts share ccache's results.
      set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${A_BATCH} UNITY_BUILD_RELOCATABLE ON)
      set_source_files_properties(${A_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      # GCC treats included files as headers and warns about anonymous namespaces in them.
      target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
    endif()
    set(scope PUBLIC)
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic
                           -Wshadow -Wnon-virtual-dtor -Wold-style-cast>)
    target_link_libraries(${name} PRIVATE ${A_PRIVATE})
  else()
    add_library(${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_include_directories(${name} ${scope} ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} ${scope} ${A_PUBLIC})
endfunction()

# diaphane_precompile(<name> headers...): parses headers once for a library whose files are compiled alone.
function(diaphane_precompile name)
  # CMake includes a header that is not in angle brackets by its path in this checkout, which no other checkout would find
  # in ccache.
  list(TRANSFORM ARGN REPLACE "^${CMAKE_BINARY_DIR}/(.+)$" "<\\1>")
  get_target_property(unity ${name} UNITY_BUILD)
  if(NOT unity)
    target_precompile_headers(${name} PRIVATE ${ARGN})
  endif()
endfunction()

# diaphane_program(<name> OUTPUT <file name> SOURCES ... LIBS ...)
function(diaphane_program name)
  cmake_parse_arguments(A "" "OUTPUT" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${A_SOURCES})
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wshadow>)
  target_link_libraries(${name} PRIVATE ${A_LIBS})
  if(A_OUTPUT)
    set_target_properties(${name} PROPERTIES OUTPUT_NAME ${A_OUTPUT})
  endif()
endfunction()

# Test programs that use several threads (./diaphane races). All others test pure functions.
set(DIAPHANE_MULTI_THREADED common_service_test directory_test api_stream_test render_thread_pool_test render_composite_test
  render_schedule_test render_session_test render_encode_test render_serve_test render_grpc_test operator_kube_test
  operator_objects_test operator_observe_test)
# Those that link gRPC, which is compiled without the sanitizer. `ignore_noninstrumented_modules` ignores its threads. It also
# hides every lock-order inversion (two were found in render_serve_test), so the other programs run without it.
set(DIAPHANE_WITH_GRPC api_stream_test render_grpc_test)

# diaphane_test(<name> SOURCES ... LIBS ... [LABELS unit|gpu|...]): a GoogleTest program beside its source.
# There is one ctest entry per program. The runner counts the cases in its report (GTEST_OUTPUT).
function(diaphane_test name)
  if(NOT DIAPHANE_TESTS)
    return()
  endif()
  cmake_parse_arguments(A "" "" "SOURCES;LIBS;LABELS" ${ARGN})
  find_package(GTest REQUIRED)
  add_executable(${name} ${A_SOURCES})
  target_link_libraries(${name} PRIVATE ${A_LIBS} GTest::gmock GTest::gtest_main)
  add_test(NAME ${name} COMMAND ${name})
  if(NOT A_LABELS)
    set(A_LABELS unit)
  endif()
  if(name IN_LIST DIAPHANE_MULTI_THREADED)
    list(APPEND A_LABELS threads)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${A_LABELS}" TIMEOUT 600)
  if(DIAPHANE_SANITIZE STREQUAL "thread")
    set(options suppressions=${CMAKE_SOURCE_DIR}/cmake/tsan-suppressions.txt)
    if(name IN_LIST DIAPHANE_WITH_GRPC)
      string(APPEND options :ignore_noninstrumented_modules=1)
    endif()
    # A sanitized program is 5 to 15 times slower.
    set_tests_properties(${name} PROPERTIES ENVIRONMENT TSAN_OPTIONS=${options} TIMEOUT 1800)
  endif()
endfunction()
