#include "volume/sealed_copy.h"

#include "volume/hash.h"

#ifdef DIAPHANE_HAVE_SODIUM
#include <sodium.h>
#endif

namespace diaphane::volume {

#ifdef DIAPHANE_HAVE_SODIUM

namespace {

// BLAKE2b with a key: for each purpose another function of the same hash.
template <std::size_t N>
void derive(std::array<unsigned char, N>& out, const std::string& from, const char* purpose) {
  const std::string key = std::string("diaphane copy: ") + purpose;
  crypto_generichash(out.data(), out.size(), reinterpret_cast<const unsigned char*>(from.data()),
                     from.size(), reinterpret_cast<const unsigned char*>(key.data()), key.size());
}

}  // namespace

Result<Seal> Seal::of(const std::string& content_hash) {
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "libsodium cannot start");
  if (content_hash.empty()) {
    return fail(ErrorCode::kUnsupported, "a volume without a hash is not copied");
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
  // The key is this content's alone, so one nonce does.
  static constexpr unsigned char kNonce[crypto_stream_xchacha20_NONCEBYTES] = {};
  static_assert(kBlock == 64, "what the cipher counts in");
  auto* at = static_cast<unsigned char*>(data);
  crypto_stream_xchacha20_xor_ic(at, at, bytes, kNonce, offset / kBlock, key_.data());
}

struct RunningHash::State {
  crypto_generichash_state hash;
};

RunningHash::RunningHash() : state_(std::make_unique<State>()) {
  crypto_generichash_init(&state_->hash, nullptr, 0, crypto_generichash_BYTES);
}
void RunningHash::add(const void* data, std::size_t bytes) {
  crypto_generichash_update(&state_->hash, static_cast<const unsigned char*>(data), bytes);
}
std::string RunningHash::end() {
  unsigned char digest[crypto_generichash_BYTES];
  crypto_generichash_final(&state_->hash, digest, sizeof digest);
  char hex[2 * sizeof digest + 1];
  sodium_bin2hex(hex, sizeof hex, digest, sizeof digest);
  return "blake2b:" + std::string(hex);
}

#else

Result<Seal> Seal::of(const std::string&) {
  return fail(ErrorCode::kUnsupported, "this build has no libsodium: volumes are not copied");
}
void Seal::apply(void*, std::size_t, std::uint64_t) const {}
struct RunningHash::State {};
RunningHash::RunningHash() = default;
void RunningHash::add(const void*, std::size_t) {}
std::string RunningHash::end() { return {}; }

#endif

RunningHash::~RunningHash() = default;

}  // namespace diaphane::volume
