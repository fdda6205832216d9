#include "renderd/engine/cuda/memory.h"

#include <algorithm>
#include <cstring>

namespace diaphane::render::cuda {
namespace {

/// Large enough for a picture of 1280 x 720. Larger pictures are copied in several pieces.
constexpr std::size_t kStagingBytes = std::size_t{3} << 20;

/// Page-locked memory. Each thread has its own, because it waits for its own copies, and keeps it,
/// because allocation is expensive.
class Staging {
 public:
  Staging() {
    if (cudaHostAlloc(&bytes_, kStagingBytes, cudaHostAllocPortable) == cudaSuccess) return;
    bytes_ = nullptr;
    (void)cudaGetLastError();  // not an error: copies work without it, but slowly
  }
  ~Staging() { cudaFreeHost(bytes_); }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;
  void* get() const { return bytes_; }

 private:
  void* bytes_ = nullptr;
};

}  // namespace

Result<void> read_back(std::uint8_t* to, const std::uint8_t* from, std::size_t bytes,
                       cudaStream_t stream) {
  thread_local const Staging staging;
  if (staging.get() == nullptr) {
    DIAPHANE_CUDA_TRY(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream));
    DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
    return {};
  }
  for (std::size_t done = 0; done < bytes; done += kStagingBytes) {
    const std::size_t piece = std::min(kStagingBytes, bytes - done);
    DIAPHANE_CUDA_TRY(
        cudaMemcpyAsync(staging.get(), from + done, piece, cudaMemcpyDeviceToHost, stream));
    DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
    std::memcpy(to + done, staging.get(), piece);
  }
  return {};
}

}  // namespace diaphane::render::cuda
