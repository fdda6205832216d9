#pragma once

#include <cstdint>

#include "renderd/math/host_device.h"

namespace diaphane::render {

/// Applies a bijection of 64 bits in which every input bit affects every output bit (Stafford's mix
/// 13, as in SplitMix64: Steele, Lea, Flood 2014).
HOST_DEVICE constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Converts 32 random bits to a number in (0, 1): the middle of one of 2^32 equal steps, so that
/// small probabilities are precise. With 24 bits, a probability of 1e-6 would be off by 1.3%.
HOST_DEVICE float to_unit(std::uint32_t bits) {
  const float u = (static_cast<float>(bits) + 0.5f) * 0x1p-32f;
  return u < 0x1.fffffep-1f ? u : 0x1.fffffep-1f;
}

/// Converts 32 random bits to an exponential variate of mean 1: -log(v) for v uniform in (0, 1).
/// The relative precision holds at both ends. Near v = 1, the distance to 1 comes from the integer
/// and not from a rounded float, so that a ray collides within an optical depth of 1e-6 with the
/// right probability. The largest value is 22.9, and the relative error is below 3e-7.
HOST_DEVICE float to_exponential(std::uint32_t bits) {
  const float v = (static_cast<float>(bits) + 0.5f) * 0x1p-32f;
  // v = m 2^e with m in [0.75, 1.5), taken from the bits of the float.
  union Bits {
    float f;
    std::uint32_t u;
  } b{v};
  const std::int32_t e = static_cast<std::int32_t>(b.u - 0x3f400000u) >> 23;
  b.u -= static_cast<std::uint32_t>(e) << 23;
  const float near_one = -(static_cast<float>(~bits) + 0.5f) * 0x1p-32f;
  const float r = bits > 0xc0000000u ? near_one : b.f - 1.0f;
  const float exponent = bits > 0xc0000000u ? 0.0f : static_cast<float>(e);
  // log(1 + r) = 2 atanh(s) with s = r / (2 + r) in [-0.143, 0.2]. The first omitted term is below
  // 1e-8.
  const float s = r / (2.0f + r);
  const float q = s * s;
  const float log1p_r =
      2.0f * s * (1.0f + q * (1.0f / 3 + q * (1.0f / 5 + q * (1.0f / 7 + q * (1.0f / 9)))));
  return -(exponent * 0.69314718056f + log1p_r);
}

/// A counter-based random number generator. Number k of the stream (seed, pixel, sample) is a pure
/// function of these four, so a picture does not depend on the number of threads, and disjoint
/// ranges of samples are independent.
class Random {
 public:
  HOST_DEVICE Random(std::uint64_t seed, std::uint32_t pixel, std::uint64_t sample)
      : key_(mix64(mix64(mix64(seed + kStep) + pixel) + sample)) {}

  /// Returns an independent stream, the one of number `which` that derives from the current state.
  /// Later draws from this stream do not affect it.
  HOST_DEVICE Random fork(std::uint32_t which) const {
    return Random(mix64(key_ ^ (std::uint64_t{which} + 1) * 0xd1342543de82ef95ULL));
  }

  HOST_DEVICE std::uint64_t bits() {
    key_ += kStep;
    return mix64(key_);
  }
  struct Pair {
    float a, b;
  };
  /// Returns two independent numbers in (0, 1).
  HOST_DEVICE Pair two() {
    const std::uint64_t x = bits();
    return {to_unit(static_cast<std::uint32_t>(x >> 32)), to_unit(static_cast<std::uint32_t>(x))};
  }
  HOST_DEVICE float one() { return to_unit(static_cast<std::uint32_t>(bits() >> 32)); }
  HOST_DEVICE float exponential() {
    return to_exponential(static_cast<std::uint32_t>(bits() >> 32));
  }
  /// Returns a number in (0, 1) and an independent exponential variate. One step of tracking needs
  /// both.
  HOST_DEVICE Pair unit_and_exponential() {
    const std::uint64_t x = bits();
    return {to_unit(static_cast<std::uint32_t>(x >> 32)),
            to_exponential(static_cast<std::uint32_t>(x))};
  }

 private:
  HOST_DEVICE explicit Random(std::uint64_t key) : key_(key) {}

  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  std::uint64_t key_;
};

}  // namespace diaphane::render
