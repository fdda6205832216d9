# The CUDA engine; included where a compiler was found (cmake/Cuda.cmake).
diaphane_library(render_cuda
  SOURCES cuda_engine.cpp cuda_error.cpp cuda_film.cpp cuda_film_kernels.cu cuda_renderer.cpp
          cuda_trace_kernel.cu cuda_volume.cpp
  PUBLIC common volume proto render_scene render_film render_kernel
  PRIVATE CUDA::cudart_static)
# Lines for compute-sanitizer and profilers; costs nothing at run time.
target_compile_options(render_cuda PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)

diaphane_test(render_cuda_unit_test SOURCES cuda_absence_test.cpp cuda_launch_size_test.cpp
              LIBS render_engine render_cuda)
# One program, because a process needs half a second to start the device.
diaphane_test(render_cuda_test
  SOURCES cuda_against_cpu_test.cpp cuda_engine_test.cpp cuda_film_test.cpp cuda_test_support.cpp
  LIBS render_cuda render_cpu CUDA::cudart_static
  LABELS gpu)
