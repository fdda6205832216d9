#include "renderd/engine/cuda/trace.cuh"
#include "tests/support/renderd/test_kernels.h"

namespace diaphane::render::cuda {
namespace {

__global__ void add_kernel(TraceTarget target, const PixelBatch* batches, std::uint64_t pixels) {
  const std::uint64_t pixel = std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (pixel < pixels) add_batch(target, pixel, batches[pixel]);
}

}  // namespace

cudaError_t add_batches(const TraceTarget& target, const PixelBatch* batches, std::uint64_t pixels,
                        cudaStream_t stream) {
  add_kernel<<<static_cast<std::uint32_t>((pixels + 255) / 256), 256, 0, stream>>>(target, batches,
                                                                                   pixels);
  return cudaGetLastError();
}

}  // namespace diaphane::render::cuda
