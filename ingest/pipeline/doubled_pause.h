#pragma once

#include <algorithm>
#include <chrono>

namespace diaphane::ingest {

/// Returns `first`, doubled for each of `times`, but at most `longest`.
inline std::chrono::milliseconds doubled_pause(std::chrono::milliseconds first, int times,
                                               std::chrono::milliseconds longest) {
  constexpr int kMostDoublings = 20;
  return std::min<std::chrono::milliseconds>(first * (1LL << std::clamp(times, 0, kMostDoublings)),
                                             longest);
}

}  // namespace diaphane::ingest
