#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "common/fd.h"

namespace diaphane {

/// A TCP connection to host:port ([address]:port for IPv6), by whichever of the host's addresses
/// takes it first within `timeout`, one after the other; it does not block. Nothing, with errno,
/// where none does.
Fd connect_tcp(const std::string& address, std::chrono::milliseconds timeout);

/// The path of an address "unix:/path", as gRPC writes it; empty for any other.
std::string unix_path(std::string_view address);

/// A connection to a Unix socket; it does not block. Nothing, with errno, where nobody listens.
Fd connect_unix(const std::string& path);

/// The longest path that a Unix socket may have, in bytes (sockaddr_un, its final zero excluded).
inline constexpr std::size_t kMostUnixPath = 107;

}  // namespace diaphane
