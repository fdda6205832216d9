#include "volume/sealed_copy.h"

#ifdef DIAPHANE_HAVE_SODIUM
#include <sodium.h>
#endif

namespace diaphane::volume {

#ifdef DIAPHANE_HAVE_SODIUM

namespace {

// Derives bytes with keyed BLAKE2b. Each purpose has its own key, so the results are independent.
template <std::size_t N>
void derive(std::array<unsigned char, N>& out, const std::string& from, const char* purpose) {
  const std::string key = std::string("diaphane copy: ") + purpose;
  crypto_generichash(out.data(), out.size(), reinterpret_cast<const unsigned char*>(from.data()),
                     from.size(), reinterpret_cast<const unsigned char*>(key.data()), key.size());
}

}  // namespace

Result<Seal> Seal::of(const std::string& content_hash) {
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "cannot initialise libsodium");
  if (content_hash.empty()) {
    return fail(ErrorCode::kUnsupported, "a volume without a hash cannot be copied");
  }
  Seal seal;
  derive(seal.key_, content_hash, "key");
  std::array<unsigned char, 16> tag{};
  derive(tag, content_hash, "name");
  char hex[2 * tag.size() + 1];
  sodium_bin2hex(hex, sizeof hex, tag.data(), tag.size());
  seal.tag_ = hex;
  return seal;
}

void Seal::apply(void* data, std::size_t bytes, std::uint64_t offset) const {
  // A constant nonce is safe, because each content has its own key.
  static constexpr unsigned char kNonce[crypto_stream_xchacha20_NONCEBYTES] = {};
  static_assert(kBlock == 64, "what the cipher counts in");
  auto* at = static_cast<unsigned char*>(data);
  crypto_stream_xchacha20_xor_ic(at, at, bytes, kNonce, offset / kBlock, key_.data());
}

#else

Result<Seal> Seal::of(const std::string&) {
  return fail(ErrorCode::kUnsupported, "this build has no libsodium, so volumes are not copied");
}
void Seal::apply(void*, std::size_t, std::uint64_t) const {}

#endif

}  // namespace diaphane::volume
