#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api::stream {

inline constexpr std::string_view kSubprotocol = "diaphane.v1";

/// The parts of a WebSocket handshake that the gateway reads, as views of the request's buffer.
struct Handshake {
  std::string_view target;  ///< "/stream?ticket=<64 hex>"
  std::string_view origin;
  std::string_view subprotocols;  ///< as offered, separated by commas
};

/// Returns the ticket if the handshake is acceptable, kInvalid for a wrong target or subprotocol,
/// or kForbidden for a missing or different origin (browsers always send one).
Result<std::string> check_handshake(const Handshake& handshake, std::string_view public_origin);

/// Returns the origin of a URL as a browser writes it: "https://host[:port]" in lower case without
/// a default port. Returns an empty string for a URL that is not http or https.
std::string origin_of(std::string_view url);

}  // namespace diaphane::api::stream
