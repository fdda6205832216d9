#pragma once

#include <string>
#include <string_view>

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

enum class DigestKind { kSha1, kSha256 };
/// The raw bytes of the digest.
std::string digest(DigestKind kind, std::string_view bytes);

}  // namespace diaphane::api
