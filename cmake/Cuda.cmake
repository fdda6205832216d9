# Finds the CUDA compiler and sets DIAPHANE_HAVE_CUDA. docs/gpu.md describes how to install it.
# Order: CMAKE_CUDA_COMPILER, CUDACXX, the toolkit that tools/devtool installs into .tools/venv, the PATH.
include_guard(GLOBAL)
set(DIAPHANE_HAVE_CUDA OFF)
if(NOT DIAPHANE_CUDA)
  return()
endif()
# CMake before 3.31 requests architectures that CUDA 13 no longer supports.
if(CMAKE_VERSION VERSION_LESS 3.31)
  message(STATUS "CUDA engine: left out, CMake ${CMAKE_VERSION} is older than 3.31 (docs/gpu.md)")
  return()
endif()

if(NOT CMAKE_CUDA_COMPILER AND NOT DEFINED ENV{CUDACXX})
  file(GLOB _wheels ${CMAKE_SOURCE_DIR}/.tools/venv/lib/python3*/site-packages/nvidia/cu13)
  foreach(_wheel ${_wheels})
    if(EXISTS ${_wheel}/bin/nvcc AND EXISTS ${_wheel}/lib64)
      set(CMAKE_CUDA_COMPILER ${_wheel}/bin/nvcc)
      set(CUDAToolkit_ROOT ${_wheel})
    endif()
  endforeach()
endif()

# Machine code for Hopper. The driver compiles the PTX for all other GPUs on the first start: that for 7.5 for Turing
# (T4, RTX 20), that for 8.0 since Ampere.
if(NOT CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 75-virtual 80-virtual 90-real)
endif()
include(CheckLanguage)
check_language(CUDA)
if(NOT CMAKE_CUDA_COMPILER)
  message(STATUS "CUDA engine: left out, no compiler (docs/gpu.md)")
  return()
endif()
set(CMAKE_CUDA_STANDARD 20)
set(CMAKE_CUDA_STANDARD_REQUIRED ON)
# Linked statically, so that the same binary also starts without the toolkit and the driver.
set(CMAKE_CUDA_RUNTIME_LIBRARY Static)
enable_language(CUDA)
find_package(CUDAToolkit 12.8 REQUIRED)
set(DIAPHANE_HAVE_CUDA ON)
message(STATUS "CUDA engine: ${CMAKE_CUDA_COMPILER} ${CMAKE_CUDA_COMPILER_VERSION}, "
               "architectures ${CMAKE_CUDA_ARCHITECTURES}")
