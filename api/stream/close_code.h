#pragma once

#include <cstdint>

namespace diaphane::api::stream {

/// Why a stream was closed (docs/contracts.md, "Stream"). A page comes back by itself with a new
/// ticket after every code but kDone, kMalformed, kSessionGone, kTakenOver, kLinkEnded and
/// kDisplaced.
enum class CloseCode : std::uint16_t {
  kDone = 1000,
  kGoingAway = 1001,    ///< the gateway stops
  kTooLarge = 1009,     ///< a message over the limit
  kInternal = 1011,     ///< a defect of ours
  kBusy = 1013,         ///< the gateway or Redis cannot take it now
  kMalformed = 4400,    ///< the client sent what is no message
  kTicket = 4401,       ///< unknown, used or too old
  kSessionGone = 4404,  ///< it was ended, or never was
  kTakenOver = 4409,    ///< opened in another window
  kLinkEnded = 4410,    ///< the link that it came by was ended
  kDisplaced = 4411,    ///< a visitor's place went to somebody with an account
  kTooMany = 4429,      ///< too many connections, or too many messages
  kWorkerLost = 4503,
};

}  // namespace diaphane::api::stream
