#include "renderd/schedule/emission.h"

namespace diaphane::render {
namespace {

/// Longer than the interval between the inputs of a drag.
constexpr double kSilentSeconds = 0.02;
constexpr double kGapSeconds = 0.03;
constexpr double kSilentGapSeconds = 0.01;

}  // namespace

bool should_emit(const EmissionQuestion& question) {
  if (question.samples == 0) return false;
  if (question.wanted_again || question.samples_shown == 0) return true;
  if (!question.moving && question.shown_moving && question.room) return true;
  if (question.samples == question.samples_shown) return false;
  if (question.converged) return true;
  if (!question.room) return false;
  // A fast device doubles its samples within milliseconds, and pictures that close together only
  // fill the connection. While inputs come, pictures are soon replaced. After the last input the
  // viewer waits, above all for the first picture whose error is known.
  const bool silent = question.seconds_since_input >= kSilentSeconds;
  if (silent && question.samples_shown < 2) return true;
  if (question.seconds_since_frame < (silent ? kSilentGapSeconds : kGapSeconds)) return false;
  if (question.samples >= 2 * question.samples_shown) return true;
  if (question.moving) return question.seconds_since_frame >= 0.12;
  return question.seconds_since_frame >= 1.0 && question.samples * 4 >= question.samples_shown * 5;
}

}  // namespace diaphane::render
