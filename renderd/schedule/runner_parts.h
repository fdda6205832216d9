// Private to runner*.cpp.
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

/// Sets a scene and the volume that it shows, unless that is null.
inline Result<void> set_scene(FrameRenderer& renderer,
                              const std::shared_ptr<const DeviceVolume>& volume,
                              const diaphane::v1::Scene& scene, Canvas canvas) {
  if (volume) {
    if (auto taken = renderer.set_volume(volume); !taken) return taken;
  }
  return renderer.set_scene(scene, canvas);
}

/// A still precedes sessions once it is owed this much device time.
inline constexpr double kStillQuantumSeconds = 0.03;

// A session on this device. All members except `gone` belong to the runner's thread, or to a lane
// while that executes a quantum of the session.
struct Runner::SessionEntry {
  explicit SessionEntry(std::uint64_t first_epoch) : ledger(first_epoch) {}

  std::uint64_t handle = 0;
  std::shared_ptr<RenderClient> client;
  std::unique_ptr<FrameRenderer> renderer;
  std::atomic<bool> gone{false};
  Ledger ledger;

  // These members always belong to the runner's thread.
  bool under_way = false;
  bool moving = false;
  SessionView last_view;     // as of the last call of refresh_views() without a quantum in flight
  WorkItem* item = nullptr;  // in flight, or in `ended_`
  std::uint64_t version_under_way = 0;  // of the request that it began with
};

struct Runner::PendingStill {
  StillJob job;
  bool prepared = false;  // the renderer has the scene
  std::uint64_t samples = 0;
};

// A unit of work for a lane, and its results.
struct Runner::WorkItem {
  std::shared_ptr<SessionEntry> entry;
  std::uint32_t samples = 0;              // 0: only makes a picture that is due
  std::optional<EmissionInput> question;  // for that picture
  std::shared_ptr<PendingStill> still;    // set instead of `entry`
  double fill = 1;
  bool spare = false;  // RenderClient::with_spare_time
  /// On a device that does not queue, this item pauses items of lower precedence. Guarded by the
  /// runner's lock once the item is in flight, like the next two.
  unsigned precedence = 0;
  double seconds_before_raise = 0;  // InFlight::raise
  bool ended = false;

  std::optional<Error> refused, failed;
  std::optional<PictureRgb8> made;  // the finished picture of a still
  double scene_seconds = 0, picture_seconds = 0, render_seconds = 0;
};

}  // namespace diaphane::render
