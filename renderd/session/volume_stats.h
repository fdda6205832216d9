#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "api/proto/stream.pb.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/scene/brain.h"
#include "renderd/scene/framing.h"
#include "renderd/session/depth.h"

namespace diaphane::render {

/// Data computed from a volume when it is loaded.
struct VolumeStats {
  diaphane::v1::Histogram histogram;
  std::shared_ptr<const CoarseVolume> coarse;
  bool has_support = false;        ///< volume::has_support()
  std::optional<Framing> framing;  ///< visible_part()
  bool contrast_agent = false;     ///< shows_contrast_agent()
  std::optional<BrainFacts> brain;
  diaphane::v1::Labels labels{};
};
/// Returns all but the coarse copy, which is of the voxels and labels that pictures show.
VolumeStats stats_of(const volume::Volume& volume);

/// The statistics of a device's volumes, each kept as long as its volume is in use. Thread-safe.
class VolumeStatsCache {
 public:
  void add(const std::shared_ptr<const DeviceVolume>& volume, VolumeStats stats);
  /// Drops the statistics of volumes that are no longer in use, because the coarse copy of a small
  /// volume contains every voxel. To be called periodically.
  void forget_expired();
  /// Returns empty statistics if they are unknown.
  VolumeStats of(const DeviceVolume& volume) const;
  /// Returns the framing of a volume, or whole_box() if it is unknown.
  Framing framing_of(const DeviceVolume& volume) const;

 private:
  struct Entry {
    std::weak_ptr<const DeviceVolume> volume;
    VolumeStats stats;
  };
  mutable std::mutex mutex_;
  std::map<const DeviceVolume*, Entry> entries_;
};

}  // namespace diaphane::render
