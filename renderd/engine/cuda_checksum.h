#pragma once

#include <cstdint>
#include <string_view>

namespace diaphane::render::cuda {

/// FNV-1a, 64 bits: tells changed and damaged files apart, and is no protection against anybody.
inline constexpr std::uint64_t kChecksumStart = 0xcbf29ce484222325ULL;
constexpr std::uint64_t checksum(std::string_view bytes, std::uint64_t sum = kChecksumStart) {
  for (const char c : bytes) {
    sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return sum;
}

}  // namespace diaphane::render::cuda
