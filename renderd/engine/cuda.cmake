# The CUDA engine; included where a compiler was found (cmake/Cuda.cmake).

# What NVRTC compiles at run time is the source of the same build, inside the program.
file(GLOB kernel_sources CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/renderd/kernel/*.h ${CMAKE_SOURCE_DIR}/renderd/math/*.h
  ${CMAKE_SOURCE_DIR}/renderd/film/film.h ${CMAKE_SOURCE_DIR}/renderd/film/guides.h ${CMAKE_CURRENT_SOURCE_DIR}/cuda_*.cuh
  ${CMAKE_CURRENT_SOURCE_DIR}/cuda_*_types.h ${CMAKE_CURRENT_SOURCE_DIR}/rtc/*)
list(FILTER kernel_sources EXCLUDE REGEX "/test_[a-z_]*[.]h$")
list(JOIN kernel_sources "\n" kernel_source_lines)
file(CONFIGURE OUTPUT kernel_sources.txt CONTENT "${kernel_source_lines}\n")
add_custom_command(OUTPUT cuda_kernel_sources.cpp
  COMMAND ${CMAKE_COMMAND} -DROOT=${CMAKE_SOURCE_DIR} -DLIST=${CMAKE_CURRENT_BINARY_DIR}/kernel_sources.txt
          -DOUT=${CMAKE_CURRENT_BINARY_DIR}/cuda_kernel_sources.cpp -P ${CMAKE_SOURCE_DIR}/cmake/EmbedSources.cmake
  DEPENDS ${kernel_sources} ${CMAKE_SOURCE_DIR}/cmake/EmbedSources.cmake
          ${CMAKE_CURRENT_BINARY_DIR}/kernel_sources.txt
  VERBATIM)

# NVRTC itself is opened at run time: the header is all that is needed of it.
diaphane_library(render_cuda
  SOURCES cuda_acceleration.cpp cuda_acceleration_kernels.cu cuda_denoise.cpp cuda_denoise_kernels.cu cuda_engine.cpp cuda_error.cpp cuda_exact_kernel.cu cuda_exact_kernels.cu cuda_exact_path.cpp cuda_exact_scratch.cpp cuda_film.cpp cuda_film_kernels.cu cuda_kernel_cache.cpp cuda_memory.cpp
          cuda_nvrtc.cpp cuda_renderer.cpp cuda_trace_kernel.cu cuda_variants.cpp cuda_volume.cpp
          ${CMAKE_CURRENT_BINARY_DIR}/cuda_kernel_sources.cpp
  PUBLIC common volume proto render_scene render_film render_kernel
  PRIVATE CUDA::cudart_static ${CMAKE_DL_LIBS})
target_compile_definitions(render_cuda PRIVATE DIAPHANE_CUDA_LIBRARIES="${CUDAToolkit_LIBRARY_DIR}")
# Lines for compute-sanitizer and profilers; costs nothing at run time.
target_compile_options(render_cuda PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)

diaphane_test(render_cuda_unit_test
  SOURCES cuda_absence_test.cpp cuda_kernel_cache_test.cpp cuda_launch_size_test.cpp cuda_nvrtc_test.cpp
          cuda_row_counts_test.cpp
  LIBS render_engine render_cuda CUDA::cudart_static)
# One program, because a process needs half a second to start the device.
diaphane_test(render_cuda_test
  SOURCES cuda_acceleration_test.cpp cuda_against_cpu_test.cpp cuda_denoise_test.cpp cuda_engine_test.cpp cuda_film_test.cpp
          cuda_test_kernels.cu cuda_test_support.cpp cuda_variants_test.cpp
  LIBS render_engine render_cuda render_cpu render_texture_libraries CUDA::cudart_static
  LABELS gpu)

if(DIAPHANE_BENCHMARKS)
  diaphane_program(render_cuda_measure OUTPUT diaphane-cuda-measure SOURCES cuda_measure.cpp
    LIBS render_cuda CUDA::cudart_static)
endif()
