#include "api/shared/idempotency.h"

#include "api/shared/secrets.h"
#include "common/ids.h"

namespace diaphane::api {

std::string token_for(std::string_view what, const IdempotencyScope& once) {
  if (once.key.empty() || once.browser.empty()) return random_hex(32);
  // The cookie or the API token comes first, because it has 256 bits of entropy.
  return blake2b(once.browser + "\n" + std::string(what) + "\n" + once.key);
}

}  // namespace diaphane::api
