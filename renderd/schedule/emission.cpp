#include "renderd/schedule/emission.h"

namespace diaphane::render {
namespace {

/// Seconds, longer than the interval between the inputs of a drag.
constexpr double kSilentSeconds = 0.02;
constexpr double kGapSeconds = 0.03;
constexpr double kSilentGapSeconds = 0.01;

}  // namespace

bool should_emit(const EmissionInput& input) {
  if (input.samples == 0) return false;
  if (input.wanted_again || input.samples_shown == 0) return true;
  if (!input.moving && input.shown_moving && input.room) return true;
  if (input.samples == input.samples_shown) return false;
  if (input.converged) return true;
  if (!input.room) return false;
  // A fast device doubles its samples within milliseconds, and pictures that close together only
  // fill the connection. While inputs come, pictures are soon replaced. After the last input the
  // viewer waits, above all for the first picture whose error is known.
  const bool silent = input.seconds_since_input >= kSilentSeconds;
  if (silent && input.samples_shown < 2) return true;
  if (input.seconds_since_frame < (silent ? kSilentGapSeconds : kGapSeconds)) return false;
  if (input.samples >= 2 * input.samples_shown) return true;
  if (input.moving) return input.seconds_since_frame >= 0.12;
  return input.seconds_since_frame >= 1.0 && input.samples * 4 >= input.samples_shown * 5;
}

}  // namespace diaphane::render
