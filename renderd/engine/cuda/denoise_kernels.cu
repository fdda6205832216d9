#include "renderd/engine/cuda/denoise.h"
#include "renderd/film/tone.h"

// The functions of film/denoise.h on the device, with one thread per pixel. Neighbours are read
// through the caches. A tap reads 36 bytes, and the arrays stay in the L2 cache during a whole
// pass, so memory does not limit the speed.

namespace diaphane::render::cuda {
namespace {

constexpr std::uint32_t kBlockX = 32, kBlockY = 8;

struct Place {
  std::int32_t x, y;
  std::uint64_t pixel;
  bool inside;
};
__device__ Place place_of(const FilmPicture& p) {
  const auto x = static_cast<std::int32_t>(blockIdx.x * kBlockX + threadIdx.x);
  const auto y = static_cast<std::int32_t>(blockIdx.y * kBlockY + threadIdx.y);
  const auto width = static_cast<std::int32_t>(p.width),
             height = static_cast<std::int32_t>(p.height);
  return {x, y, static_cast<std::uint64_t>(x) + std::uint64_t{p.width} * y,
          x < width && y < height};
}

__device__ Smoothed smoothed_of(Float4 v) { return {{v.x, v.y, v.z}, v.w}; }
__device__ Float4 packed(const Smoothed& s) { return {s.mean.x, s.mean.y, s.mean.z, s.deviation}; }

__global__ void __launch_bounds__(kBlockX* kBlockY)
    read_kernel(const __grid_constant__ DenoiseWork w) {
  const Place at = place_of(w.picture);
  if (!at.inside) return;
  const std::uint64_t samples = w.picture.samples.of(static_cast<std::uint32_t>(at.y));
  const PixelEstimate e = estimate_of(w.picture.film, at.pixel, samples);
  const Guides g = unpack(w.guides[at.pixel]);
  w.buffers.raw[at.pixel] = packed(to_be_smoothed(e, 1.0f / w.white));
  w.buffers.steering[at.pixel] =
      pack(steering_of(g, takes_part(w.picture.film, at.pixel, samples, g)));
}

/// Computes slopes, and the deviation of pixels of one sample, which have no halves.
__global__ void __launch_bounds__(kBlockX* kBlockY)
    steer_kernel(const __grid_constant__ DenoiseWork w) {
  const Place at = place_of(w.picture);
  if (!at.inside) return;
  const auto width = static_cast<std::int32_t>(w.picture.width);
  const auto height = static_cast<std::int32_t>(w.picture.height);
  const std::uint64_t right = at.x + 1 < width ? at.pixel + 1 : at.pixel;
  const std::uint64_t below = at.y + 1 < height ? at.pixel + width : at.pixel;
  const std::uint64_t left = at.x > 0 ? at.pixel - 1 : at.pixel;
  const std::uint64_t above = at.y > 0 ? at.pixel - width : at.pixel;
  const Steering here = unpack(w.buffers.steering[at.pixel]);
  // At an edge of the picture, the only neighbour is used for both sides.
  const auto depth = [&](std::uint64_t a, std::uint64_t b) {
    return unpack(w.buffers.steering[a == at.pixel ? b : a]).depth;
  };
  w.buffers.slope[at.pixel] = slope_of(depth(left, right), here.depth, depth(right, left)) +
                              slope_of(depth(above, below), here.depth, depth(below, above));
  if (w.picture.samples.of(static_cast<std::uint32_t>(at.y)) >= 2) return;
  NeighbourDeviation deviation;
  const Smoothed mine = smoothed_of(w.buffers.raw[at.pixel]);
  const auto offer = [&](std::uint64_t other) {
    if (other == at.pixel) return;
    deviation.offer(mine, here, smoothed_of(w.buffers.raw[other]),
                    unpack(w.buffers.steering[other]), w.voxel);
  };
  offer(right);
  offer(below);
  offer(left);
  offer(above);
  // No other thread of this kernel uses this number.
  w.buffers.raw[at.pixel].w = deviation.value;
}

/// Computes the variance, the mean of d^2 over 7 x 7 pixels, from a tile in shared memory.
__global__ void __launch_bounds__(kBlockX* kBlockY)
    variance_kernel(const __grid_constant__ DenoiseWork w) {
  constexpr std::int32_t kReach = kVarianceReach;
  constexpr std::int32_t kWide = kBlockX + 2 * kReach, kHigh = kBlockY + 2 * kReach;
  __shared__ float squares[kHigh][kWide];
  __shared__ float counts[kHigh][kWide];
  const Place at = place_of(w.picture);
  const auto width = static_cast<std::int32_t>(w.picture.width);
  const auto height = static_cast<std::int32_t>(w.picture.height);
  const std::int32_t x0 = static_cast<std::int32_t>(blockIdx.x * kBlockX) - kReach;
  const std::int32_t y0 = static_cast<std::int32_t>(blockIdx.y * kBlockY) - kReach;
  for (std::int32_t i = static_cast<std::int32_t>(threadIdx.x + kBlockX * threadIdx.y);
       i < kWide * kHigh; i += kBlockX * kBlockY) {
    const std::int32_t x = x0 + i % kWide, y = y0 + i / kWide;
    float square = 0.0f, count = 0.0f;
    if (x >= 0 && y >= 0 && x < width && y < height) {
      const std::uint64_t pixel =
          static_cast<std::uint64_t>(x) + std::uint64_t{w.picture.width} * y;
      count = unpack(w.buffers.steering[pixel]).takes_part;
      square = count * squared(w.buffers.raw[pixel].w);
    }
    squares[i / kWide][i % kWide] = square;
    counts[i / kWide][i % kWide] = count;
  }
  __syncthreads();
  if (!at.inside) return;
  float sum = 0.0f, count = 0.0f;
  for (std::int32_t dy = 0; dy <= 2 * kReach; ++dy) {
    for (std::int32_t dx = 0; dx <= 2 * kReach; ++dx) {
      sum += squares[threadIdx.y + dy][threadIdx.x + dx];
      count += counts[threadIdx.y + dy][threadIdx.x + dx];
    }
  }
  w.buffers.variance[at.pixel] = count > 0.0f ? sum / count : 0.0f;
}

__global__ void __launch_bounds__(kBlockX* kBlockY)
    pass_kernel(const __grid_constant__ DenoiseWork w, const Float4* __restrict__ from,
                const float* __restrict__ from_variance, Float4* __restrict__ to,
                float* __restrict__ to_variance, std::int32_t stride) {
  const Place at = place_of(w.picture);
  if (!at.inside) return;
  const Steering here = unpack(w.buffers.steering[at.pixel]);
  const Smoothed mine = smoothed_of(from[at.pixel]);
  const float variance = from_variance[at.pixel];
  // The pixel keeps its raw value, so there is nothing to filter.
  if (!(here.takes_part > 0.0f)) {
    to[at.pixel] = packed(mine);
    to_variance[at.pixel] = variance;
    return;
  }
  const auto width = static_cast<std::int32_t>(w.picture.width);
  const auto height = static_cast<std::int32_t>(w.picture.height);
  const float slope = w.buffers.slope[at.pixel];
  const float trust = luminance_trust(stride);
  Float3 sum{0.0f, 0.0f, 0.0f};
  float deviation = 0.0f, variances = 0.0f, weights = 0.0f;
#pragma unroll
  for (std::int32_t dy = -kDenoiseReach; dy <= kDenoiseReach; ++dy) {
    const std::int32_t y = at.y + dy * stride;
    if (y < 0 || y >= height) continue;
#pragma unroll
    for (std::int32_t dx = -kDenoiseReach; dx <= kDenoiseReach; ++dx) {
      const std::int32_t x = at.x + dx * stride;
      if (x < 0 || x >= width) continue;
      const std::uint64_t other =
          static_cast<std::uint64_t>(x) + std::uint64_t{w.picture.width} * y;
      const Smoothed theirs = smoothed_of(from[other]);
      const float distance =
          static_cast<float>(stride) * sqrtf(static_cast<float>(dx * dx + dy * dy));
      const float weight =
          tap_weight(mine, variance, trust, here, slope, theirs, unpack(w.buffers.steering[other]),
                     spline_weight(dx) * spline_weight(dy), distance, w.voxel);
      sum += theirs.mean * weight;
      deviation += weight * theirs.deviation;
      variances += weight * weight * from_variance[other];
      weights += weight;
    }
  }
  const float inverse = 1.0f / weights;  // not 0, because the pixel's own weight is included
  to[at.pixel] = packed({sum * inverse, deviation * inverse});
  to_variance[at.pixel] = variances * inverse * inverse;
}

/// Sums one tile per block, with one thread per pixel. The sum is a tree, so that its order and its
/// bits are always the same.
__global__ void __launch_bounds__(kGainTile* kGainTile)
    gain_kernel(const __grid_constant__ DenoiseWork w, const Float4* __restrict__ filtered) {
  constexpr std::uint32_t kThreads = kGainTile * kGainTile;
  __shared__ Gain gains[kThreads];
  const std::uint32_t t = threadIdx.x;
  const std::uint32_t x = blockIdx.x * kGainTile + t % kGainTile;
  const std::uint32_t y = blockIdx.y * kGainTile + t / kGainTile;
  gains[t] = {0.0f, 0.0f};
  if (x < w.picture.width && y < w.picture.height) {
    const std::uint64_t pixel = x + std::uint64_t{w.picture.width} * y;
    if (unpack(w.buffers.steering[pixel]).takes_part > 0.0f) {
      gains[t] = gain_of(smoothed_of(w.buffers.raw[pixel]), smoothed_of(filtered[pixel]));
    }
  }
  for (std::uint32_t half = kThreads / 2; half != 0; half /= 2) {
    __syncthreads();
    if (t < half) {
      gains[t].less_noise += gains[t + half].less_noise;
      gains[t].change += gains[t + half].change;
    }
  }
  if (t == 0) w.buffers.gains[blockIdx.x + gridDim.x * blockIdx.y] = gains[0];
}

__global__ void __launch_bounds__(kBlockX* kBlockY)
    blend_kernel(const __grid_constant__ DenoiseWork w, const Float4* __restrict__ filtered,
                 float scale, std::uint8_t* rgb, float* radiance) {
  const Place at = place_of(w.picture);
  if (!at.inside) return;
  Float3 shown =
      estimate_of(w.picture.film, at.pixel, w.picture.samples.of(static_cast<std::uint32_t>(at.y)))
          .mean;
  if (unpack(w.buffers.steering[at.pixel]).takes_part > 0.0f) {
    const GainsView gains{w.buffers.gains, (w.picture.width + kGainTile - 1) / kGainTile,
                          (w.picture.height + kGainTile - 1) / kGainTile};
    const float share =
        w.fade * share_of_filtered(gain_around(gains, static_cast<std::uint32_t>(at.x),
                                               static_cast<std::uint32_t>(at.y)));
    shown = blended(shown, smoothed_of(filtered[at.pixel]).mean * w.white, share);
  }
  for (int c = 0; c < 3; ++c) {
    if (rgb != nullptr) rgb[3 * at.pixel + c] = to_display(shown[c], scale, w.curve);
    if (radiance != nullptr) radiance[3 * at.pixel + c] = shown[c];
  }
}

}  // namespace

cudaError_t denoise(DenoiseWork w, float scale, std::uint8_t* rgb, float* radiance,
                    cudaStream_t stream) {
  const FilmPicture& p = w.picture;
  const dim3 block(kBlockX, kBlockY);
  const dim3 grid((p.width + kBlockX - 1) / kBlockX, (p.height + kBlockY - 1) / kBlockY);
  DenoiseBuffers& b = w.buffers;
  read_kernel<<<grid, block, 0, stream>>>(w);
  steer_kernel<<<grid, block, 0, stream>>>(w);
  variance_kernel<<<grid, block, 0, stream>>>(w);
  const Float4* from = b.raw;
  const float* variance = b.variance;
  for (std::uint32_t pass = 0; pass < kDenoisePasses; ++pass) {
    Float4* to = pass % 2 == 0 ? b.to : b.from;
    float* to_variance = pass % 2 == 0 ? b.to_variance : b.from_variance;
    pass_kernel<<<grid, block, 0, stream>>>(w, from, variance, to, to_variance, 1 << pass);
    from = to;
    variance = to_variance;
  }
  const dim3 tiles((p.width + kGainTile - 1) / kGainTile, (p.height + kGainTile - 1) / kGainTile);
  gain_kernel<<<tiles, kGainTile * kGainTile, 0, stream>>>(w, from);
  blend_kernel<<<grid, block, 0, stream>>>(w, from, scale, rgb, radiance);
  return cudaGetLastError();
}

}  // namespace diaphane::render::cuda
