#include "renderd/engine/cuda/kernels.h"

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
  // atomicAdd() is not defined for std::uint64_t, which is another type of the same size.
  atomicAdd(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(count));
}

__device__ PixelEstimate estimate_at(const FilmPicture& p, std::uint64_t pixel) {
  return estimate_of(p.film, pixel, p.samples.of(static_cast<std::uint32_t>(pixel / p.width)));
}

__global__ void histogram_kernel(FilmPicture p, std::uint64_t* counts) {
  __shared__ std::uint32_t mine[kWhiteCounts];
  for (std::uint32_t i = threadIdx.x; i < kWhiteCounts; i += blockDim.x) mine[i] = 0;
  __syncthreads();
  const std::uint64_t pixels = std::uint64_t{p.width} * p.height;
  const std::uint64_t stride = std::uint64_t{gridDim.x} * blockDim.x;
  for (std::uint64_t pixel = thread_index(); pixel < pixels; pixel += stride) {
    const PixelEstimate e = estimate_at(p, pixel);
    if (!e.hit_medium) continue;
    const WhiteEntries entries = white_entries(e, pixel);
#pragma unroll
    for (int i = 0; i < 6; ++i) atomicAdd(&mine[entries.of[i]], 1u);
  }
  __syncthreads();
  for (std::uint32_t i = threadIdx.x; i < kWhiteCounts; i += blockDim.x) {
    if (mine[i] != 0) add(&counts[i], mine[i]);
  }
}

/// Sums one tile per block, with one thread per pixel. The sum is a tree, so that its order and its
/// bits are always the same.
__global__ void tile_kernel(FilmPicture p, float inverse_white, ToneCurve curve, TileError* tiles) {
  static_assert(kTileSize * kTileSize == kBlock);
  __shared__ float squared[kBlock];
  __shared__ std::uint32_t counted[kBlock];
  const std::uint32_t t = threadIdx.x;
  const std::uint32_t x = blockIdx.x * kTileSize + t % kTileSize;
  const std::uint32_t y = blockIdx.y * kTileSize + t / kTileSize;
  squared[t] = 0;
  counted[t] = 0;
  if (x < p.width && y < p.height) {
    const PixelEstimate e = estimate_at(p, x + std::uint64_t{p.width} * y);
    if (e.hit_medium) {
      squared[t] = squared_error(e, inverse_white, curve);
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

__global__ void display_kernel(FilmPicture p, float scale, ToneCurve curve, std::uint8_t* rgb) {
  const std::uint64_t pixel = thread_index();
  if (pixel >= std::uint64_t{p.width} * p.height) return;
  const Float3 mean = estimate_at(p, pixel).mean;
  rgb[3 * pixel] = to_display(mean.x, scale, curve);
  rgb[3 * pixel + 1] = to_display(mean.y, scale, curve);
  rgb[3 * pixel + 2] = to_display(mean.z, scale, curve);
}

__global__ void mean_kernel(FilmPicture p, std::uint64_t first, std::uint64_t count, float* rgb) {
  const std::uint64_t i = thread_index();
  if (i >= count) return;
  const Float3 mean = estimate_at(p, first + i).mean;
  rgb[3 * i] = mean.x;
  rgb[3 * i + 1] = mean.y;
  rgb[3 * i + 2] = mean.z;
}

__global__ void pack_kernel(FilmView film, std::uint64_t first, std::uint64_t count,
                            std::uint64_t samples, PackedPixel* out) {
  const std::uint64_t i = thread_index();
  if (i >= count) return;
  const std::uint64_t pixel = first + i;
  out[i] = pack_pixel({film.sum, film.difference, film.state}, pixel, samples);
  for (std::uint64_t c = 3 * pixel; c < 3 * pixel + 3; ++c) {
    film.sum[c] = 0;
    film.difference[c] = 0;
  }
  film.state[pixel] = 0;
}

__global__ void merge_kernel(const PackedPixel* packed, std::uint64_t first, std::uint64_t count,
                             std::uint64_t samples, FilmView film) {
  const std::uint64_t i = thread_index();
  if (i < count) merge_pixel(film, first + i, packed[i], samples);
}

std::uint64_t pixels_of(const FilmPicture& p) { return std::uint64_t{p.width} * p.height; }

}  // namespace

cudaError_t white_histogram(const FilmPicture& picture, std::uint64_t* counts,
                            cudaStream_t stream) {
  // Each thread takes several pixels, because a block adds its whole histogram to the result.
  const std::uint32_t blocks = min(blocks_for((pixels_of(picture) + 7) / 8), 1024u);
  histogram_kernel<<<blocks, kBlock, 0, stream>>>(picture, counts);
  return cudaGetLastError();
}

cudaError_t tile_errors(const FilmPicture& picture, float inverse_white, ToneCurve curve,
                        TileError* tiles, cudaStream_t stream) {
  const dim3 grid((picture.width + kTileSize - 1) / kTileSize,
                  (picture.height + kTileSize - 1) / kTileSize);
  tile_kernel<<<grid, kBlock, 0, stream>>>(picture, inverse_white, curve, tiles);
  return cudaGetLastError();
}

cudaError_t display_film(const FilmPicture& picture, float scale, ToneCurve curve,
                         std::uint8_t* rgb, cudaStream_t stream) {
  display_kernel<<<blocks_for(pixels_of(picture)), kBlock, 0, stream>>>(picture, scale, curve, rgb);
  return cudaGetLastError();
}

cudaError_t mean_of_film(const FilmPicture& picture, std::uint64_t first, std::uint64_t count,
                         float* rgb, cudaStream_t stream) {
  mean_kernel<<<blocks_for(count), kBlock, 0, stream>>>(picture, first, count, rgb);
  return cudaGetLastError();
}

cudaError_t pack_film(const FilmView& film, std::uint64_t first, std::uint64_t count,
                      std::uint64_t samples, PackedPixel* out, cudaStream_t stream) {
  pack_kernel<<<blocks_for(count), kBlock, 0, stream>>>(film, first, count, samples, out);
  return cudaGetLastError();
}

cudaError_t merge_packed(const PackedPixel* packed, std::uint64_t first, std::uint64_t count,
                         std::uint64_t samples, const FilmView& film, cudaStream_t stream) {
  merge_kernel<<<blocks_for(count), kBlock, 0, stream>>>(packed, first, count, samples, film);
  return cudaGetLastError();
}

}  // namespace diaphane::render::cuda
