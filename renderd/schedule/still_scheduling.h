#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace diaphane::render {

/// Priority of stills, highest first.
enum class StillRank {
  kAwaited,     ///< a user sees the place where it will appear
  kBackground,  ///< no one waits for it
  kFile,        ///< a picture of a file, which takes minutes; it never slows down a moving picture
};

/// Returns the seconds that stills get per second that the device is busy, by the rank of the first
/// one. Awaited stills get half, but little while a session moves. A file gets half as well,
/// because its user waits for minutes and pictures at rest are good enough to look at meanwhile,
/// but nothing while a session moves. The share is a share of time, not of turns: one sample of a
/// large canvas on a slow device takes a second, so a turn of 30 ms between two of them would make
/// a thumbnail wait for a minute.
inline double still_share(StillRank first, std::size_t moving_sessions) {
  constexpr double kShare = 0.5, kShareInBackground = 1.0 / 16;
  if (first == StillRank::kFile) return moving_sessions > 0 ? 0 : kShare;
  return moving_sessions > 0 || first != StillRank::kAwaited ? kShareInBackground : kShare;
}

/// Returns whether a still of this rank may be rendered at all. A file is not even rendered in the
/// pauses of a drag, because the next input would have to wait for it.
inline bool still_may_run(StillRank rank, std::size_t moving_sessions) {
  return rank != StillRank::kFile || moving_sessions == 0;
}

/// Returns the time that stills are owed after a quantum of `spent` seconds. The samples of a file
/// may take longer than the time owed; the debt is then given back to the sessions.
inline double still_due_after(StillRank rank, double due, double spent) {
  constexpr double kLongestDebt = 1;
  return std::max(due - spent, rank == StillRank::kFile ? -kLongestDebt : 0.0);
}

/// The samples and the error of a still, and those requested.
struct StillSoFar {
  std::uint64_t samples = 0, samples_wanted = 1;
  double error = 0, error_wanted = 0;  ///< `error_wanted` of 0: no error is good enough
  bool late = false;                   ///< whether its deadline has passed
};

/// Returns whether to make the picture from the current samples. It needs at least one.
inline bool still_is_rendered(const StillSoFar& still) {
  if (still.samples == 0) return false;
  const bool good = still.error_wanted > 0 && still.error <= still.error_wanted;
  return still.samples >= still.samples_wanted || still.late || good;
}

}  // namespace diaphane::render
