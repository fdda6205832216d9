#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"

/// Cryptography for accounts and uploads, based on libsodium and libcrypto.
namespace diaphane::api {

/// BLAKE2b-256 of `text` as 64 lower-case hexadecimal digits. Tokens are random and 256 bits long,
/// so a plain hash is enough to keep them out of the database (no salt, no stretching).
std::string blake2b(std::string_view text);

/// Compares in time that depends only on the lengths.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// Whether the text is 64 lower-case hexadecimal digits, the form of every token that we issue.
bool is_token(std::string_view text);

/// Derives a UUID from a text, for resources whose creation is idempotent.
std::string id_from(std::string_view text);

/// Encrypts values that the database must return and not only compare. The key comes from a file.
/// Uses XChaCha20-Poly1305.
class SealingKey {
 public:
  /// Reads the key from a file with 64 hexadecimal digits. Returns kInvalid if the file is missing
  /// or malformed.
  static Result<SealingKey> read(const std::string& path);
  /// Returns kInvalid unless the text is 64 hexadecimal digits.
  static Result<SealingKey> of_hex(std::string_view text);

  /// Returns hexadecimal text. `whose` is not secret, but must be the same for opening, so that a
  /// sealed text cannot be moved to another account.
  std::string seal(std::string_view plain, std::string_view whose) const;
  /// Returns nothing if the text is damaged or was sealed with another key or another `whose`.
  std::optional<std::string> open(std::string_view sealed, std::string_view whose) const;
  /// Returns the keyed BLAKE2b-128 hash of `text` in hexadecimal.
  std::string mac(std::string_view text) const;

 private:
  SealingKey() = default;
  std::array<unsigned char, 32> key_{};
};

enum class DigestKind { kSha1, kSha256 };
/// Returns the raw bytes of the digest.
std::string digest(DigestKind kind, std::string_view bytes);

}  // namespace diaphane::api
