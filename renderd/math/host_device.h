#pragma once

// The same source is compiled for CPU and CUDA. On the CPU everything is forced inline: the kernel
// is compiled once per instruction set, and the linker could keep an out-of-line copy of an inline
// function that this processor cannot execute.
#if defined(__CUDACC__)
// Precedes a loop that must not be unrolled, even if the compiler knows its length.
#define DEVICE_NO_UNROLL _Pragma("unroll 1")
#define HOST_DEVICE __host__ __device__ __forceinline__
#else
#define DEVICE_NO_UNROLL
#define HOST_DEVICE [[gnu::always_inline]] inline
#endif
