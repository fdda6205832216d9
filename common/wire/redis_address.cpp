#include "common/wire/redis_address.h"

#include <charconv>

#include "common/connect.h"

namespace diaphane::wire {
namespace {

constexpr std::string_view kWithTls = "rediss://";

}  // namespace

bool wants_tls(std::string_view address) { return address.starts_with(kWithTls); }

Result<RedisAddress> parse_redis_address(std::string_view text) {
  RedisAddress address;
  if (address.path = unix_path(text); !address.path.empty()) {
    if (address.path.front() != '/' || address.path.size() > kMostUnixPath) {
      return fail(ErrorCode::kInvalid, "unix:PATH must be an absolute path of at most " +
                                           std::to_string(kMostUnixPath) + " bytes");
    }
    return address;
  }
  address.with_tls = wants_tls(text);
  if (address.with_tls) text.remove_prefix(kWithTls.size());
  const std::size_t colon = text.rfind(':');
  const std::string_view port = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  const auto [end, wrong] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  std::string_view host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  if (host.empty() || wrong != std::errc() || end != port.data() + port.size() ||
      address.port == 0) {
    return fail(ErrorCode::kInvalid, "must be unix:PATH or host:port with a port from 1 to 65535");
  }
  address.host = host;
  return address;
}

}  // namespace diaphane::wire
