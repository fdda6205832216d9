#pragma once

#include <chrono>
#include <string>

#include "common/fd.h"

namespace diaphane {

/// A TCP connection to host:port ([address]:port for IPv6), by whichever of the host's addresses
/// takes it first within `timeout`, one after the other; it does not block. Nothing, with errno,
/// where none does.
Fd connect_tcp(const std::string& address, std::chrono::milliseconds timeout);

}  // namespace diaphane
