#include "volume/frame_of_reference.h"

#include <algorithm>
#include <array>

#ifdef DIAPHANE_HAVE_SODIUM
#include <sodium.h>
#endif

namespace diaphane::volume {
namespace {

constexpr std::string_view kPrefix = "blake2b:";
constexpr std::size_t kSaltBytes = 16;
constexpr std::size_t kHashBytes = 32;
constexpr std::size_t kHiddenLength = kPrefix.size() + 2 * kSaltBytes + 1 + 2 * kHashBytes;

}  // namespace

bool is_hidden_frame_of_reference(std::string_view text) {
  return text.size() == kHiddenLength && text.starts_with(kPrefix) &&
         text[kPrefix.size() + 2 * kSaltBytes] == ':' &&
         text.substr(kPrefix.size()).find_first_not_of("0123456789abcdef:") ==
             std::string_view::npos;
}

#ifdef DIAPHANE_HAVE_SODIUM
namespace {

using Salt = std::array<unsigned char, kSaltBytes>;

template <std::size_t N>
std::string hex_of(const std::array<unsigned char, N>& bytes) {
  std::string hex(2 * N + 1, '\0');
  sodium_bin2hex(hex.data(), hex.size(), bytes.data(), N);
  hex.pop_back();
  return hex;
}

std::string hidden(const std::string& uid, const Salt& salt) {
  const std::string disguised = disguised_uid(uid);
  std::array<unsigned char, kHashBytes> hash{};
  crypto_generichash(hash.data(), hash.size(),
                     reinterpret_cast<const unsigned char*>(disguised.data()), disguised.size(),
                     salt.data(), salt.size());
  return std::string(kPrefix) + hex_of(salt) + ":" + hex_of(hash);
}

/// Returns the decimal form of a big-endian number.
std::string decimal_of(std::array<unsigned char, 16> number) {
  std::string digits;
  for (bool is_zero = false; !is_zero;) {
    unsigned rest = 0;
    is_zero = true;
    for (unsigned char& byte : number) {
      const unsigned value = 256 * rest + byte;
      byte = static_cast<unsigned char>(value / 10);
      rest = value % 10;
      is_zero = is_zero && byte == 0;
    }
    digits.insert(digits.begin(), static_cast<char>('0' + rest));
  }
  return digits;
}

}  // namespace

Result<std::string> hidden_frame_of_reference(const std::string& uid) {
  if (uid.empty()) return std::string();
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "cannot initialise libsodium");
  Salt salt{};
  randombytes_buf(salt.data(), salt.size());
  return hidden(uid, salt);
}

bool is_frame_of_reference(const std::string& stored, const std::string& uid) {
  if (stored.empty() || uid.empty()) return true;
  Salt salt{};
  std::size_t bytes = 0;
  if (!is_hidden_frame_of_reference(stored) ||
      sodium_hex2bin(salt.data(), salt.size(), stored.data() + kPrefix.size(), 2 * kSaltBytes,
                     nullptr, &bytes, nullptr) != 0) {
    return false;
  }
  return hidden(uid, salt) == stored;
}

std::string disguised_uid(const std::string& uid) {
  if (uid.empty() || uid.starts_with("2.25.")) return uid;
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(uid.data()), uid.size());
  std::array<unsigned char, 16> first{};
  std::copy(hash.begin(), hash.begin() + 16, first.begin());
  return "2.25." + decimal_of(first);
}
#else
Result<std::string> hidden_frame_of_reference(const std::string& uid) {
  if (uid.empty()) return uid;
  return fail(ErrorCode::kUnsupported, "this build has no libsodium");
}
bool is_frame_of_reference(const std::string& stored, const std::string& uid) {
  // A build without libsodium cannot compare hashes.
  return stored.empty() || uid.empty() || is_hidden_frame_of_reference(stored);
}
std::string disguised_uid(const std::string& uid) { return uid; }
#endif

}  // namespace diaphane::volume
