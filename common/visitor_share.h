#pragma once

#include <algorithm>
#include <cstddef>

namespace diaphane {

/// Percentage of all slots that visitors and guests (people without an account) may hold together.
inline constexpr int kVisitorPercent = 25;

/// Number of `slots` that visitors and guests may hold together: their share, rounded down, but one
/// if account holders keep at least one. directory/scripts/place.lua applies the same rule to a
/// fleet.
inline constexpr std::size_t visitor_slots(std::size_t slots, int percent) {
  if (slots < 2 || percent <= 0) return 0;
  return std::max<std::size_t>(slots * static_cast<std::size_t>(percent) / 100, 1);
}

/// Number of one worker's slots that they may hold: as above, but rounded up, so that a fleet of
/// small workers can use its share.
inline constexpr std::size_t visitor_slots_of_worker(std::size_t slots, int percent) {
  return percent <= 0 ? 0 : (slots * static_cast<std::size_t>(percent) + 99) / 100;
}

/// Number of these slots that one source (an address or a link) may hold: half, but two if there
/// are two, so that two people behind one address can view a scan.
inline constexpr std::size_t visitor_slots_of_source(std::size_t share) {
  return std::min(share, std::max<std::size_t>(share / 2, 2));
}

}  // namespace diaphane
