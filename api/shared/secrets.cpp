#include "api/shared/secrets.h"

#include <openssl/evp.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace diaphane::api {
namespace {

std::array<unsigned char, 32> blake2b_raw(std::string_view text) {
  std::array<unsigned char, 32> raw{};
  crypto_generichash(raw.data(), raw.size(), reinterpret_cast<const unsigned char*>(text.data()),
                     text.size(), nullptr, 0);
  return raw;
}

constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;

const unsigned char* bytes_of(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

std::string hex(const unsigned char* data, std::size_t size) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(size * 2);
  for (std::size_t i = 0; i < size; ++i) {
    text += kDigits[data[i] >> 4];
    text += kDigits[data[i] & 15];
  }
  return text;
}

}  // namespace

std::string blake2b(std::string_view text) {
  const auto raw = blake2b_raw(text);
  return hex(raw.data(), raw.size());
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool is_token(std::string_view text) {
  return text.size() == 64 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

std::string id_from(std::string_view text) {
  auto raw = blake2b_raw(text);
  // Sets the version and variant bits of a UUID of version 8 (custom, RFC 9562).
  raw[6] = static_cast<unsigned char>((raw[6] & 0x0f) | 0x80);
  raw[8] = static_cast<unsigned char>((raw[8] & 0x3f) | 0x80);
  const std::string all = hex(raw.data(), 16);
  return all.substr(0, 8) + '-' + all.substr(8, 4) + '-' + all.substr(12, 4) + '-' +
         all.substr(16, 4) + '-' + all.substr(20);
}

Result<SealingKey> SealingKey::read(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  if (!(file >> text)) return fail(ErrorCode::kInvalid, "the file does not exist or is empty");
  return of_hex(text);
}

Result<SealingKey> SealingKey::of_hex(std::string_view text) {
  SealingKey key;
  static_assert(crypto_aead_xchacha20poly1305_ietf_KEYBYTES == 32);
  if (!is_token(text)) return fail(ErrorCode::kInvalid, "the key must be 64 hexadecimal digits");
  if (sodium_hex2bin(key.key_.data(), key.key_.size(), text.data(), text.size(), nullptr, nullptr,
                     nullptr) != 0) {
    return fail(ErrorCode::kInvalid, "the key must be 64 hexadecimal digits");
  }
  return key;
}

std::string SealingKey::seal(std::string_view plain, std::string_view whose) const {
  std::vector<unsigned char> sealed(kNonceBytes + plain.size() + kTagBytes);
  randombytes_buf(sealed.data(), kNonceBytes);
  crypto_aead_xchacha20poly1305_ietf_encrypt(sealed.data() + kNonceBytes, nullptr, bytes_of(plain),
                                             plain.size(), bytes_of(whose), whose.size(), nullptr,
                                             sealed.data(), key_.data());
  return hex(sealed.data(), sealed.size());
}

std::optional<std::string> SealingKey::open(std::string_view sealed, std::string_view whose) const {
  std::vector<unsigned char> raw(sealed.size() / 2);
  std::size_t size = 0;
  const bool is_hex = sodium_hex2bin(raw.data(), raw.size(), sealed.data(), sealed.size(), nullptr,
                                     &size, nullptr) == 0;
  if (!is_hex || size < kNonceBytes + kTagBytes) return std::nullopt;
  std::string plain(size - kNonceBytes - kTagBytes, '\0');
  const int done = crypto_aead_xchacha20poly1305_ietf_decrypt(
      reinterpret_cast<unsigned char*>(plain.data()), nullptr, nullptr, raw.data() + kNonceBytes,
      size - kNonceBytes, bytes_of(whose), whose.size(), raw.data(), key_.data());
  if (done != 0) return std::nullopt;
  return plain;
}

std::string SealingKey::mac(std::string_view text) const {
  std::array<unsigned char, 16> raw{};
  crypto_generichash(raw.data(), raw.size(), bytes_of(text), text.size(), key_.data(), key_.size());
  return hex(raw.data(), raw.size());
}

std::string digest(DigestKind kind, std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> raw{};
  unsigned int size = 0;
  const EVP_MD* algorithm = kind == DigestKind::kSha1 ? EVP_sha1() : EVP_sha256();
  if (EVP_Digest(bytes.data(), bytes.size(), raw.data(), &size, algorithm, nullptr) != 1) {
    throw std::runtime_error("EVP_Digest failed");
  }
  return std::string(raw.begin(), raw.begin() + size);
}

}  // namespace diaphane::api
