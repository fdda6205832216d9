#pragma once

namespace diaphane::directory {

// Constants of the session directory. embed_scripts.cmake gives every script of scripts/ these
// constants under the same names, so each value is a number or a product on one line.

/// Version of the protocol between gateway and worker. Sessions are placed only on workers with the
/// same version.
inline constexpr int kProtocolEpoch = 1;

/// A worker is forgotten this long after its last heartbeat.
inline constexpr int kHeartbeatMs = 3000;
/// A heartbeat keeps the slot of each of its sessions for this long.
inline constexpr int kSessionHeldMs = 10000;
/// The sets of occupied slots expire this long after their last change.
inline constexpr int kSlotsS = 60;
/// A session is forgotten this long after its last use.
inline constexpr int kSessionS = 24 * 3600;
/// A session or sign-in that was ended on purpose is remembered as ended for this long.
inline constexpr int kEndedS = 60;
inline constexpr int kLinkS = 12 * 3600;
/// A link that was ended is remembered as ended for this long.
inline constexpr int kLinkEndedS = 24 * 3600;
/// A session that found no slot counts as demand for this long.
inline constexpr int kUnplacedMs = 5000;
inline constexpr int kUnplacedS = 60;
/// An operator's instruction to drain expires after this time.
inline constexpr int kDrainMs = 10000;

/// With more workers than this, placement considers this many at random.
inline constexpr int kSampledWorkers = 64;
/// A loaded volume saves memory and a second at the start. In the choice of a worker for a session
/// or for assisting one, it is worth this share of a device.
inline constexpr double kLoadedVolumeWorth = 0.25;

}  // namespace diaphane::directory
