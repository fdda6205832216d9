#include "renderd/engine/cuda_kernels.h"

namespace diaphane::render::cuda {
namespace {

constexpr std::uint32_t kBlock = 256;

std::uint32_t blocks_for(std::uint64_t count) {
  return static_cast<std::uint32_t>((count + kBlock - 1) / kBlock);
}

__device__ std::uint64_t thread_index() {
  return std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
}

__device__ void add(std::uint64_t* to, std::uint32_t count) {
  // The same 64 bits, but another type to the compiler.
  atomicAdd(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(count));
}

__global__ void fold_kernel(FilmView film, const PixelBatch* batch, std::uint64_t pixels,
                            std::uint64_t* dropped) {
  const std::uint64_t pixel = thread_index();
  if (pixel >= pixels) return;
  const PixelBatch& b = batch[pixel];
  fold(film, pixel, b);
  if (const std::uint32_t count = b.dropped_even + b.dropped_odd; count != 0) {
    add(dropped, count);
  }
}

__global__ void histogram_kernel(ConstFilmView film, std::uint64_t pixels, std::uint64_t samples,
                                 std::uint64_t* counts) {
  __shared__ std::uint32_t mine[kWhiteBins];
  for (std::uint32_t i = threadIdx.x; i < kWhiteBins; i += blockDim.x) mine[i] = 0;
  __syncthreads();
  const std::uint64_t stride = std::uint64_t{gridDim.x} * blockDim.x;
  for (std::uint64_t pixel = thread_index(); pixel < pixels; pixel += stride) {
    const PixelEstimate e = estimate_of(film, pixel, samples);
    if (!e.met_matter) continue;
    atomicAdd(&mine[white_bin(e.mean.x)], 1u);
    atomicAdd(&mine[white_bin(e.mean.y)], 1u);
    atomicAdd(&mine[white_bin(e.mean.z)], 1u);
  }
  __syncthreads();
  for (std::uint32_t i = threadIdx.x; i < kWhiteBins; i += blockDim.x) {
    if (mine[i] != 0) add(&counts[i], mine[i]);
  }
}

/// One block a tile, one thread a pixel; the sum is a tree, so it is the same each time.
__global__ void tile_kernel(ConstFilmView film, std::uint32_t width, std::uint32_t height,
                            std::uint64_t samples, float inverse_white, TileError* tiles) {
  static_assert(kTileSize * kTileSize == kBlock);
  __shared__ float squared[kBlock];
  __shared__ std::uint32_t counted[kBlock];
  const std::uint32_t t = threadIdx.x;
  const std::uint32_t x = blockIdx.x * kTileSize + t % kTileSize;
  const std::uint32_t y = blockIdx.y * kTileSize + t / kTileSize;
  squared[t] = 0;
  counted[t] = 0;
  if (x < width && y < height) {
    const PixelEstimate e = estimate_of(film, x + std::uint64_t{width} * y, samples);
    if (e.met_matter) {
      squared[t] = squared_error(e, inverse_white);
      counted[t] = 1;
    }
  }
  for (std::uint32_t half = kBlock / 2; half != 0; half /= 2) {
    __syncthreads();
    if (t < half) {
      squared[t] += squared[t + half];
      counted[t] += counted[t + half];
    }
  }
  if (t == 0) tiles[blockIdx.x + gridDim.x * blockIdx.y] = {squared[0], counted[0]};
}

__global__ void display_kernel(ConstFilmView film, std::uint64_t pixels, std::uint64_t samples,
                               float scale, std::uint8_t* rgb) {
  const std::uint64_t pixel = thread_index();
  if (pixel >= pixels) return;
  const Float3 mean = estimate_of(film, pixel, samples).mean;
  rgb[3 * pixel] = to_display(mean.x, scale);
  rgb[3 * pixel + 1] = to_display(mean.y, scale);
  rgb[3 * pixel + 2] = to_display(mean.z, scale);
}

__global__ void mean_kernel(ConstFilmView film, std::uint64_t pixels, std::uint64_t samples,
                            float* rgb) {
  const std::uint64_t pixel = thread_index();
  if (pixel >= pixels) return;
  const Float3 mean = estimate_of(film, pixel, samples).mean;
  rgb[3 * pixel] = mean.x;
  rgb[3 * pixel + 1] = mean.y;
  rgb[3 * pixel + 2] = mean.z;
}

}  // namespace

cudaError_t fold_batch(const FilmView& film, const PixelBatch* batch, std::uint64_t pixels,
                       std::uint64_t* dropped, cudaStream_t stream) {
  fold_kernel<<<blocks_for(pixels), kBlock, 0, stream>>>(film, batch, pixels, dropped);
  return cudaGetLastError();
}

cudaError_t white_histogram(const ConstFilmView& film, std::uint64_t pixels, std::uint64_t samples,
                            std::uint64_t* counts, cudaStream_t stream) {
  // Some pixels a thread, so that the blocks' histograms are worth their making.
  const std::uint32_t blocks = smaller(blocks_for((pixels + 7) / 8), 1024u);
  histogram_kernel<<<blocks, kBlock, 0, stream>>>(film, pixels, samples, counts);
  return cudaGetLastError();
}

cudaError_t tile_errors(const ConstFilmView& film, std::uint32_t width, std::uint32_t height,
                        std::uint64_t samples, float inverse_white, TileError* tiles,
                        cudaStream_t stream) {
  const dim3 grid((width + kTileSize - 1) / kTileSize, (height + kTileSize - 1) / kTileSize);
  tile_kernel<<<grid, kBlock, 0, stream>>>(film, width, height, samples, inverse_white, tiles);
  return cudaGetLastError();
}

cudaError_t display_film(const ConstFilmView& film, std::uint64_t pixels, std::uint64_t samples,
                         float scale, std::uint8_t* rgb, cudaStream_t stream) {
  display_kernel<<<blocks_for(pixels), kBlock, 0, stream>>>(film, pixels, samples, scale, rgb);
  return cudaGetLastError();
}

cudaError_t mean_of_film(const ConstFilmView& film, std::uint64_t pixels, std::uint64_t samples,
                         float* rgb, cudaStream_t stream) {
  mean_kernel<<<blocks_for(pixels), kBlock, 0, stream>>>(film, pixels, samples, rgb);
  return cudaGetLastError();
}

}  // namespace diaphane::render::cuda
