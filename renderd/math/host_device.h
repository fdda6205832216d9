#pragma once

// One source for CPU and CUDA. On the CPU everything is forced inline: the kernel is compiled once
// per instruction set, and a shared out-of-line copy of an inline function could be the one for the
// wrong processor.
#if defined(__CUDACC__)
#define HOST_DEVICE __host__ __device__ __forceinline__
#else
#define HOST_DEVICE [[gnu::always_inline]] inline
#endif
