# The CUDA engine; included where a compiler was found (cmake/Cuda.cmake).
diaphane_library(render_cuda
  SOURCES cuda_engine.cpp cuda_error.cpp cuda_film.cpp cuda_film_kernels.cu cuda_renderer.cpp
          cuda_trace_kernel.cu cuda_volume.cpp
  PUBLIC common volume proto render_scene render_film render_kernel
  PRIVATE CUDA::cudart_static)
# Lines for compute-sanitizer and profilers; costs nothing at run time.
target_compile_options(render_cuda PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)
