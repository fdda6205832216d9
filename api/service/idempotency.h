#pragma once

#include <string>
#include <string_view>

namespace diaphane::api {

/// A key by which a person's request makes its thing once, however often it comes (for a day).
struct IdempotencyKey {
  std::string route;
  std::string key;
  std::string request_hash;  ///< secrets.h, blake2b
};

struct Created {
  std::string id;  ///< with `again`, of the one that the same key made before
  bool again = false;
};
struct KeyReused {};  ///< the key came before with another request

/// For what is made with a secret that is kept nowhere, as a link's token is.
struct Once {
  std::string key;      ///< of the request; empty: each makes another
  std::string browser;  ///< what the person's browser alone knows: its cookie
};

/// A token of 256 bits (secrets.h, is_token): random, or with a key the same each time that this
/// browser asks for `what` by that key. Nobody has it from what is stored: it is made of the
/// cookie, of which only a hash is kept.
std::string token_for(std::string_view what, const Once& once);

}  // namespace diaphane::api
