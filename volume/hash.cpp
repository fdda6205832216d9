#include "volume/hash.h"

#ifdef DIAPHANE_HAVE_SODIUM
#include <sodium.h>
#endif

namespace diaphane::volume {

#ifdef DIAPHANE_HAVE_SODIUM
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
  unsigned char digest[crypto_generichash_BYTES];  // 32
  crypto_generichash_final(&state_->hash, digest, sizeof digest);
  char hex[2 * sizeof digest + 1];
  sodium_bin2hex(hex, sizeof hex, digest, sizeof digest);
  return "blake2b:" + std::string(hex);
}

Result<std::string> content_hash(const void* data, std::size_t bytes) {
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "cannot initialise libsodium");
  RunningHash hash;
  hash.add(data, bytes);
  return hash.end();
}
#else
Result<std::string> content_hash(const void*, std::size_t) {
  return fail(ErrorCode::kUnsupported,
              "this build has no libsodium, so volumes cannot be verified");
}
struct RunningHash::State {};
RunningHash::RunningHash() = default;
void RunningHash::add(const void*, std::size_t) {}
std::string RunningHash::end() { return {}; }
#endif

RunningHash::~RunningHash() = default;

}  // namespace diaphane::volume
