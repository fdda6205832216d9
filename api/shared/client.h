#pragma once

#include <string>

namespace diaphane::api {

/// The sender of a request, as the edge reports it.
struct Client {
  std::string address;  ///< IPv4 or IPv6, or "local" without an edge
  std::string browser;  ///< approximate, such as "Firefox on Windows"; never the User-Agent itself
};

/// Returns the first 16 bits of an IPv4 address or the first 32 bits of an IPv6 address as a
/// network ("203.0.0.0/16"). That is a provider and a region, but not a household. Returns an empty
/// string for anything else.
std::string coarse_network(const std::string& address);

}  // namespace diaphane::api
