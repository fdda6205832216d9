#pragma once

#include <cstdint>

namespace diaphane::render {

/// Input of should_emit().
struct EmissionInput {
  std::uint64_t samples = 0;        ///< per pixel, accumulated so far
  std::uint64_t samples_shown = 0;  ///< samples in the last picture of this epoch; 0: none yet
  double seconds_since_frame = 0;   ///< since the last picture of any epoch
  double seconds_since_input = 0;
  bool moving = false;
  bool shown_moving = false;  ///< the last picture was encoded for speed
  bool converged = false;
  bool wanted_again = false;  ///< a viewer returned, or their input changed nothing
  bool room = true;           ///< the encoder slot is free and the connection keeps up
};

/// Decides whether the accumulated picture is shown. Pure. It is shown in these cases:
/// - The epoch has a first sample.
/// - The samples have doubled and the last picture is at least 30 ms old, or 10 ms if no input has
///   come for 20 ms. In that case the second picture of an epoch that shows one sample does not
///   wait.
/// - The session moves, has more samples, and the last picture is at least 120 ms old.
/// - The session has come to rest after a picture that was encoded for speed.
/// - At rest there are a quarter more samples, and the last picture is at least 1 s old.
/// - The picture has converged.
/// - The viewer wants it again.
///
/// Without room only the first picture of an epoch, the converged one and one wanted again are
/// shown; they replace the picture that waits.
bool should_emit(const EmissionInput& input);

}  // namespace diaphane::render
