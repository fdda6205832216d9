#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/result.h"

namespace diaphane::volume {

/// Encrypts copies of voxels outside the volume store with XChaCha20. The key is derived from the
/// content hash, which is stored only in the volume's header in the store and not with the copy.
/// Once the volume is erased or replaced there, its copies cannot be decrypted, even if they are
/// never deleted.
class Seal {
 public:
  /// Derives the key. Returns kUnsupported in a build without libsodium or for a volume without a
  /// hash.
  static Result<Seal> of(const std::string& content_hash);

  /// Distinguishes copies of different contents in file names without revealing the hash.
  const std::string& tag() const { return tag_; }

  /// Encrypts or decrypts in place the bytes that start at `offset` in the file. `offset` must be a
  /// multiple of kBlock.
  void apply(void* data, std::size_t bytes, std::uint64_t offset) const;
  static constexpr std::size_t kBlock = 64;

 private:
  Seal() = default;
  std::array<unsigned char, 32> key_{};
  std::string tag_;
};

}  // namespace diaphane::volume
