#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "common/fd.h"

namespace diaphane {

/// Opens a TCP connection to host:port ([address]:port for IPv6) as a non-blocking socket. Tries
/// the addresses of the host one after the other and uses the first that accepts within `timeout`.
/// Returns an empty Fd and sets errno if none does.
Fd connect_tcp(const std::string& address, std::chrono::milliseconds timeout);

/// Returns the path of a "unix:/path" address (gRPC's syntax), or an empty string for any other.
std::string unix_path(std::string_view address);

/// Connects to a Unix socket (non-blocking). Returns an empty Fd and sets errno on failure.
Fd connect_unix(const std::string& path);

/// Maximum path length of a Unix socket in bytes (sockaddr_un without its terminating zero).
inline constexpr std::size_t kMostUnixPath = 107;

}  // namespace diaphane
