// Of runner*.cpp alone.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>

#include "renderd/schedule/runner.h"

namespace diaphane::render {

inline double seconds_between(std::chrono::steady_clock::time_point from,
                              std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// A still goes before sessions once it is due this much of the device.
inline constexpr double kStillQuantumSeconds = 0.03;

// A session on this device. All but `gone` belongs to the runner's thread, and while a quantum is
// under way to the lane that has it.
struct Runner::Track {
  explicit Track(std::uint64_t first_epoch) : ledger(first_epoch) {}

  std::uint64_t handle = 0;
  std::shared_ptr<RenderClient> client;
  std::unique_ptr<FrameRenderer> renderer;
  std::atomic<bool> gone{false};
  Ledger ledger;

  // Of the runner's thread, always.
  bool under_way = false;
  bool moving = false;
  SessionView seen;  // when it was last looked at
};

struct Runner::Still {
  StillJob job;
  std::uint64_t samples = 0;
};

// What a lane has to do, and what came of it.
struct Runner::Turn {
  std::shared_ptr<Track> track;
  std::uint32_t samples = 0;                 // 0: none, a picture is due
  std::optional<EmissionQuestion> question;  // of that picture
  std::shared_ptr<Still> still;              // instead of a track
  double fill = 1;

  std::optional<Error> refused, failed;
  std::optional<PictureRgb8> made;  // the still's, once it has all its samples
  double scene_seconds = 0, picture_seconds = 0, render_seconds = 0;
};

}  // namespace diaphane::render
