#pragma once

#include <cstdint>

namespace diaphane::render {

/// What is known when it is decided whether the accumulated picture is shown.
struct EmissionQuestion {
  std::uint64_t samples = 0;        ///< per pixel, accumulated now
  std::uint64_t samples_shown = 0;  ///< in the last picture of this epoch; 0: none yet
  double seconds_since_frame = 0;   ///< since the last picture of any epoch
  double seconds_since_input = 0;
  bool moving = false;
  bool shown_moving = false;  ///< the last picture was coded for speed
  bool converged = false;
  bool wanted_again = false;  ///< a viewer came back, or its input changed nothing
  bool room = true;           ///< its slot before the encoder is free and it keeps up
};

/// Pure: the first sample of an epoch at once, then each doubling, but not within 30 ms; while
/// moving every 120 ms; once when it came to rest, for the quality; at rest at least each second
/// when a quarter more samples came in; and the converged one. Without room only what replaces the
/// picture that waits: a new epoch's first, and the last.
bool should_emit(const EmissionQuestion& question);

}  // namespace diaphane::render
