#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"

/// Cryptography for accounts and uploads, based on libsodium and libcrypto.
namespace diaphane::api {

/// Returns BLAKE2b-256 of `text` as 64 lower-case hexadecimal digits. Tokens are random and 256
/// bits long, so a plain hash without salt or stretching keeps them out of the database.
std::string blake2b(std::string_view text);

/// Compares two texts in a time that depends only on their lengths.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// Returns whether the text has the form of our tokens: 64 lower-case hexadecimal digits.
bool is_token(std::string_view text);

/// Derives a UUID from a text, for resources whose creation is idempotent.
std::string id_from(std::string_view text);

/// Encrypts values that the server must read back from the database, unlike passwords, which it
/// only compares. Uses XChaCha20-Poly1305.
class SealingKey {
 public:
  /// Reads the key from a file with 64 hexadecimal digits. Returns kInvalid if the file is missing
  /// or malformed.
  static Result<SealingKey> read(const std::string& path);
  /// Returns kInvalid unless the text is 64 hexadecimal digits.
  static Result<SealingKey> of_hex(std::string_view text);

  /// Returns the encrypted text in hexadecimal. `whose` is the associated data: open() requires the
  /// same, so that a sealed text cannot be moved to another account.
  std::string seal(std::string_view plain, std::string_view whose) const;
  /// Decrypts `sealed`. Returns nothing if it is damaged or the key or `whose` is a different one.
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
