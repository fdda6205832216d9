#include "volume/hash.h"

#ifdef DIAPHANE_HAVE_SODIUM
#include <sodium.h>
#endif

namespace diaphane::volume {

#ifdef DIAPHANE_HAVE_SODIUM
Result<std::string> content_hash(const void* data, std::size_t bytes) {
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "libsodium cannot start");
  unsigned char digest[crypto_generichash_BYTES];  // 32
  crypto_generichash(digest, sizeof digest, static_cast<const unsigned char*>(data), bytes, nullptr,
                     0);
  char hex[2 * sizeof digest + 1];
  sodium_bin2hex(hex, sizeof hex, digest, sizeof digest);
  return "blake2b:" + std::string(hex);
}
#else
Result<std::string> content_hash(const void*, std::size_t) {
  return fail(ErrorCode::kUnsupported, "this build has no libsodium: a volume cannot be verified");
}
#endif

}  // namespace diaphane::volume
