#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace diaphane::render {

/// In this order they go before each other, and behind sessions more and more.
enum class StillRank {
  kAwaited,     ///< somebody looks at where it will be
  kBackground,  ///< nobody waits for it
  kFile,        ///< of a file that takes minutes: it slows nobody's moving picture
};

/// The stills' seconds for each second that the device is busy, by the first of them: a third of
/// the device, little while somebody drags. By time, not by turns: a sample of a large canvas on a
/// slow device takes a second, and a turn of 30 ms between two of them would let a thumbnail wait
/// for a minute.
inline double still_share(StillRank first, std::size_t moving_sessions) {
  constexpr double kShare = 0.5, kShareInBackground = 1.0 / 16;
  if (first == StillRank::kFile && moving_sessions > 0) return 0;
  return moving_sessions > 0 || first != StillRank::kAwaited ? kShareInBackground : kShare;
}

/// Whether one may be rendered at all: beside a hand that moves, not even in the pauses, since
/// the next input would have to wait for it.
inline bool still_may_run(StillRank rank, std::size_t moving_sessions) {
  return rank != StillRank::kFile || moving_sessions == 0;
}

/// What is due to them after a quantum of `spent` seconds. A file's samples may take longer than
/// was due: then the sessions get that time back.
inline double still_due_after(StillRank rank, double due, double spent) {
  constexpr double kLongestDebt = 1;
  return std::max(due - spent, rank == StillRank::kFile ? -kLongestDebt : 0.0);
}

/// What a still has got, and what was asked for.
struct StillSoFar {
  std::uint64_t samples = 0, samples_wanted = 1;
  double error = 0, error_wanted = 0;  ///< 0 wanted: no error is good enough
  bool late = false;                   ///< somebody must have it now
};

/// Whether its picture is made of what is there: one sample at least.
inline bool still_is_rendered(const StillSoFar& still) {
  if (still.samples == 0) return false;
  const bool good = still.error_wanted > 0 && still.error <= still.error_wanted;
  return still.samples >= still.samples_wanted || still.late || good;
}

}  // namespace diaphane::render
