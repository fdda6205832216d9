#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/result.h"

namespace diaphane::volume {

/// How a copy of voxels lies outside the volume store: enciphered (XChaCha20) by a key that is made
/// of their content hash. That hash is in the volume's header in the store and nowhere beside the
/// copy: once the volume is erased or replaced there, nobody can read its copies, on whatever disk
/// they are and whether or not anybody comes to remove them.
class Seal {
 public:
  /// kUnsupported in a build without libsodium, or for a volume without a hash.
  static Result<Seal> of(const std::string& content_hash);

  /// What tells copies of different contents apart in their names; says nothing of the hash.
  const std::string& tag() const { return tag_; }

  /// Enciphers or deciphers in place what lies `offset` bytes after the beginning; `offset` is a
  /// multiple of kBlock.
  void apply(void* data, std::size_t bytes, std::uint64_t offset) const;
  static constexpr std::size_t kBlock = 64;

 private:
  Seal() = default;
  std::array<unsigned char, 32> key_{};
  std::string tag_;
};

}  // namespace diaphane::volume
