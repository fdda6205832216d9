#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "common/result.h"

namespace diaphane::volume {

/// Returns "blake2b:" and the hexadecimal BLAKE2b-256 (RFC 7693) of the bytes. Returns kUnsupported
/// in a build without libsodium.
Result<std::string> content_hash(const void* data, std::size_t bytes);

/// Computes the same hash piece by piece. Call sodium_init() first. Without libsodium, end()
/// returns an empty string.
class RunningHash {
 public:
  RunningHash();
  ~RunningHash();
  RunningHash(const RunningHash&) = delete;
  RunningHash& operator=(const RunningHash&) = delete;
  void add(const void* data, std::size_t bytes);
  std::string end();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace diaphane::volume
