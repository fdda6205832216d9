#pragma once

#include <cstdint>

namespace diaphane::api::stream {

/// The reason why a stream was closed, as the code of the WebSocket close frame. The values and the
/// page's reaction to each are part of the protocol (docs/contracts.md, "Stream"), so they must not
/// change.
enum class CloseCode : std::uint16_t {
  kDone = 1000,
  kGoingAway = 1001,    ///< the gateway is stopping
  kTooLarge = 1009,     ///< a message exceeds the limit
  kInternal = 1011,     ///< a bug in Diaphane
  kBusy = 1013,         ///< the gateway or Redis is overloaded
  kMalformed = 4400,    ///< the client sent a malformed message
  kTicket = 4401,       ///< the ticket is unknown, used or expired
  kSessionGone = 4404,  ///< the session has ended or never existed
  kTakenOver = 4409,    ///< the session was opened in another window
  kLinkEnded = 4410,    ///< the viewer's link was disabled
  kDisplaced = 4411,    ///< a visitor's place was given to a signed-in user
  kTooMany = 4429,      ///< too many connections or messages
  kWorkerLost = 4503,
};

}  // namespace diaphane::api::stream
