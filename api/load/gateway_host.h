#pragma once

#include <cstdint>
#include <string>

namespace diaphane::api::load {

/// The gateway of `api` as a program of its own: no accounts, no Postgres. Tickets are those of the
/// real scripts in the real Redis.
struct GatewayHost {
  std::string redis;  ///< host:port
  std::uint16_t stream_port = 0;
  std::uint16_t admin_port = 0;
  std::string public_url;
};

/// Serves until SIGTERM; the exit code.
int serve_gateway(const GatewayHost& settings);

}  // namespace diaphane::api::load
