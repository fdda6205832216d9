#pragma once

#include <algorithm>
#include <cstddef>

namespace diaphane {

/// Slots, in percent, that visitors and guests (people without an account) may hold together.
inline constexpr int kVisitorPercent = 25;

/// How many of `slots` visitors and guests may hold together: their share rounded down, but one
/// wherever account holders keep at least one. api/redis/place.lua has the same rule for a fleet.
inline constexpr std::size_t visitor_slots(std::size_t slots, int percent) {
  if (slots < 2 || percent <= 0) return 0;
  return std::max<std::size_t>(slots * static_cast<std::size_t>(percent) / 100, 1);
}

/// How many of one worker's slots they may hold: as above, rounded up, so that a fleet of small
/// workers can use its share.
inline constexpr std::size_t visitor_slots_of_worker(std::size_t slots, int percent) {
  return percent <= 0 ? 0 : (slots * static_cast<std::size_t>(percent) + 99) / 100;
}

/// How much of such a share one source may hold, an address or a link: half, but two where there
/// are two, so that two people behind one address can look.
inline constexpr std::size_t visitor_slots_of_source(std::size_t share) {
  return std::min(share, std::max<std::size_t>(share / 2, 2));
}

}  // namespace diaphane
