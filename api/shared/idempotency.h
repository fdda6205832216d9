#pragma once

#include <string>
#include <string_view>

namespace diaphane::api {

/// A key that makes a user's request create its resource only once, even if repeated within a day.
struct IdempotencyKey {
  std::string route;
  std::string key;
  std::string request_hash;  ///< BLAKE2b hash of the request (secrets.h)
};

struct Created {
  std::string id;  ///< with `again`: ID of the resource that the same key created before
  bool again = false;
};
struct KeyReused {};  ///< the key was used before with a different request

/// The inputs from which token_for derives a resource's secret, which is not stored.
struct IdempotencyScope {
  std::string key;      ///< key of the request; if empty, each request creates a new resource
  std::string browser;  ///< the session cookie, or the API token of a program
};

/// Returns a token of 256 bits (secrets.h, is_token). It is random without a key and otherwise the
/// same each time that this browser or program requests `what` with that key. It cannot be derived
/// from stored data, because only a hash of the cookie or of the API token is stored.
std::string token_for(std::string_view what, const IdempotencyScope& once);

}  // namespace diaphane::api
