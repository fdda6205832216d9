#pragma once

#include <cstdint>

namespace diaphane::fleet {

/// Random numbers for one plan: a pure function of the seed (SplitMix64: Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t x = (state_ += 0x9e3779b97f4a7c15ULL);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  }
  /// Returns a number in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// Returns a number in [0, count). The bias is below count / 2^64.
  std::size_t below(std::size_t count) { return bits() % count; }

 private:
  std::uint64_t state_;
};

}  // namespace diaphane::fleet
