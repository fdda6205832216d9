#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"

/// The little cryptography that accounts and uploads need, over libsodium and libcrypto.
namespace diaphane::api {

/// BLAKE2b-256 of `text` as 64 lower-case hexadecimal digits. Tokens are random and 256 bits long,
/// so a plain hash is enough to keep them out of the database (no salt, no stretching).
std::string blake2b(std::string_view text);

/// In time that depends on the lengths alone.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// 64 lower-case hexadecimal digits: the form of every token that we give out.
bool is_token(std::string_view text);

/// A UUID that is the same for the same text: for things whose creation is idempotent by a key.
std::string id_from(std::string_view text);

/// Keeps what the database holds and must give back (not only compare) unreadable without a file of
/// ours: XChaCha20-Poly1305.
class SealingKey {
 public:
  /// From a file with 64 hexadecimal digits. kInvalid: there is no such file, or something else in
  /// it.
  static Result<SealingKey> read(const std::string& path);
  /// kInvalid: not 64 hexadecimal digits.
  static Result<SealingKey> of_hex(std::string_view text);

  /// In hexadecimal. `whose` is no secret; it must be the same when opened, so that nobody's sealed
  /// text serves somebody else.
  std::string seal(std::string_view plain, std::string_view whose) const;
  /// Nothing: sealed with another key, for another `whose`, or damaged.
  std::optional<std::string> open(std::string_view sealed, std::string_view whose) const;
  /// A keyed BLAKE2b-128 of `text`, in hexadecimal: only who has the key can make it.
  std::string mac(std::string_view text) const;

 private:
  SealingKey() = default;
  std::array<unsigned char, 32> key_{};
};

enum class DigestKind { kSha1, kSha256 };
/// The raw bytes of the digest.
std::string digest(DigestKind kind, std::string_view bytes);

}  // namespace diaphane::api
