#pragma once

#include <algorithm>
#include <cstddef>

namespace diaphane {

/// Percentage of all slots that visitors and guests (people without an account) may hold together.
inline constexpr int kVisitorPercent = 25;

/// Returns how many of `slots` visitors and guests may hold together: their share, rounded down,
/// but one if account holders keep at least one. directory/scripts/place.lua applies the same rule
/// to a fleet.
inline constexpr std::size_t visitor_slots(std::size_t slots, int percent) {
  if (slots < 2 || percent <= 0) return 0;
  return std::max<std::size_t>(slots * static_cast<std::size_t>(percent) / 100, 1);
}

/// Returns how many slots of one worker visitors and guests may hold: their share, rounded up, so
/// that a fleet of small workers can use it.
inline constexpr std::size_t visitor_slots_of_worker(std::size_t slots, int percent) {
  return percent <= 0 ? 0 : (slots * static_cast<std::size_t>(percent) + 99) / 100;
}

/// Returns how many slots of `share` one source (an address or a link) may hold: half, but two if
/// there are two, so that two people behind one address can view a scan.
inline constexpr std::size_t visitor_slots_of_source(std::size_t share) {
  return std::min(share, std::max<std::size_t>(share / 2, 2));
}

}  // namespace diaphane
