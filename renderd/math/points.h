#pragma once

#include <cstdint>

#include "renderd/math/random.h"

// Low-discrepancy points for the few dimensions of a sample that matter most: Sobol's
// (0,2)-sequence, Owen-scrambled by hashing and padded (Burley 2020, "Practical Hash-based Owen
// Scrambling"; the hash is Vegdahl's from 2021). Each pair of dimensions is a separate sequence,
// whose index is shuffled so that pairs are independent of each other.
//
// The even and the odd samples are two sequences with separate scrambles. They give two independent
// estimates of the picture, so their difference measures the error of this sampler in the same way
// as that of independent samples.

namespace diaphane::render {

HOST_DEVICE std::uint32_t reverse_bits(std::uint32_t x) {
#if defined(__CUDA_ARCH__)
  return __brev(x);
#else
  x = (x >> 16) | (x << 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
#endif
}

/// Owen-scrambles a bit-reversed number: each bit is flipped by a hash of the bits below it.
HOST_DEVICE std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

/// Returns Sobol's second dimension, bit-reversed: `index` times Pascal's triangle modulo 2.
HOST_DEVICE std::uint32_t sobol_second_reversed(std::uint32_t index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 8) & 0x00ff00ffu;
  index ^= (index >> 16) & 0x0000ffffu;
  return index;
}

/// The low-discrepancy points of one sample of one pixel. For comparison, estimators can draw from
/// the random number generator instead (Method::low_discrepancy).
class Points {
 public:
  /// The purpose of a pair of dimensions.
  enum Use : std::uint32_t {
    kPixel,
    kLens,
    kAreaLight,
    kEnvironment,
    kScatter,
    kPick,
    kAreaLightByScatter,
    kEnvironmentMap,
    kDepth
  };

  /// `sample` counts from 0 within its stream, which is a hash of the seed and the first sample of
  /// Random. Samples 2i and 2i + 1 belong to different halves of the film.
  HOST_DEVICE Points(std::uint64_t stream, std::uint32_t pixel, std::uint64_t sample)
      : key_(mix64(mix64(stream + 0x9e3779b97f4a7c15ULL) +
                   (std::uint64_t{pixel} << 1 | (sample & 1)))),
        index_(static_cast<std::uint32_t>(sample >> 1)) {
    if ((sample >> 33) != 0) key_ = mix64(key_ + (sample >> 33));
  }

  /// Returns this sample's pair of numbers in (0, 1) for `use`.
  HOST_DEVICE Random::Pair pair(std::uint32_t use) const { return pair(use, index_); }
  /// Returns point `index` of the sequence for `use`. An estimate that takes n points per sample
  /// uses the points i * n to i * n + n - 1 for sample i.
  HOST_DEVICE Random::Pair pair(std::uint32_t use, std::uint32_t index) const {
    const std::uint64_t k = mix64(key_ + (std::uint64_t{use} + 1) * 0xd1342543de82ef95ULL);
    const std::uint32_t shuffle = static_cast<std::uint32_t>(k);
    const std::uint32_t other = static_cast<std::uint32_t>(k >> 32);
    // The index is shuffled within each block of 2^m points, so that the block stays a net.
    const std::uint32_t i = reverse_bits(scramble_reversed(reverse_bits(index), shuffle));
    const std::uint32_t a = reverse_bits(scramble_reversed(i, other));
    const std::uint32_t b = reverse_bits(
        scramble_reversed(sobol_second_reversed(i), other * 0x9e3779b1u + 0x7f4a7c15u));
    return {to_unit(a), to_unit(b)};
  }
  HOST_DEVICE std::uint32_t index() const { return index_; }

 private:
  std::uint64_t key_;
  std::uint32_t index_;
};

}  // namespace diaphane::render
