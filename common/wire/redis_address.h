#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::wire {

struct RedisAddress {
  std::string host;  ///< an IPv6 address without its brackets
  std::string path;  ///< path of a Unix socket; then the other fields are empty
  std::uint16_t port = 0;
  bool with_tls = false;
};

/// Returns whether the address is "rediss://host:port".
bool wants_tls(std::string_view address);

/// Parses "host:port", "rediss://host:port" (TLS) or "unix:/path", or returns kInvalid.
Result<RedisAddress> parse_redis_address(std::string_view text);

}  // namespace diaphane::wire
