#pragma once

#include <cstdint>
#include <string_view>

namespace diaphane::render::cuda {

/// 64-bit FNV-1a hash. It detects changed and damaged files but does not protect against deliberate
/// changes.
inline constexpr std::uint64_t kChecksumStart = 0xcbf29ce484222325ULL;
constexpr std::uint64_t checksum(std::string_view bytes, std::uint64_t sum = kChecksumStart) {
  for (const char c : bytes) {
    sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return sum;
}

}  // namespace diaphane::render::cuda
