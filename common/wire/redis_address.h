#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"
#include "common/wire/inner_tls.h"

namespace diaphane::wire {

struct RedisAddress {
  std::string host;  ///< an address of IPv6 without its brackets
  std::string path;  ///< of a Unix socket, which then is all there is
  std::uint16_t port = 0;
  bool with_tls = false;
  TlsFiles tls{};  ///< that it is spoken to with, given by who connects
};

/// "rediss://host:port".
bool wants_tls(std::string_view address);

/// "host:port", "rediss://host:port" with TLS, or "unix:/path". kInvalid: it is none of these.
Result<RedisAddress> parse_redis_address(std::string_view text);

}  // namespace diaphane::wire
