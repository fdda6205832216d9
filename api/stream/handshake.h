#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api::stream {

inline constexpr std::string_view kSubprotocol = "diaphane.v1";

/// What the gateway reads of a WebSocket handshake. Views of the request's own buffer.
struct Handshake {
  std::string_view target;  ///< "/stream?ticket=<64 hex>"
  std::string_view origin;
  std::string_view subprotocols;  ///< as offered, separated by commas
};

/// The ticket, when the handshake may be accepted. kInvalid: target or subprotocol; kForbidden: a
/// page of another origin (or none: browsers always send one).
Result<std::string> check_handshake(const Handshake& handshake, std::string_view public_origin);

/// "https://host[:port]" of an address, as a browser writes it in `Origin`: lower case, no default
/// port. Empty when it is no http or https address.
std::string origin_of(std::string_view url);

}  // namespace diaphane::api::stream
