#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "api/proto/stream.pb.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/session/depth.h"

namespace diaphane::render {

/// Data computed from a volume when it is loaded.
struct VolumeFacts {
  diaphane::v1::Histogram histogram;
  std::shared_ptr<const CoarseVolume> coarse;
};
VolumeFacts facts_of(const volume::Volume& volume);

/// The facts of a device's volumes, each kept as long as its volume is in use. Thread-safe.
class KeptFacts {
 public:
  void add(const std::shared_ptr<const DeviceVolume>& volume, VolumeFacts facts);
  /// Drops the facts of volumes that are no longer in use, because the coarse copy of a small
  /// volume contains every voxel. To be called periodically.
  void forget_expired();
  /// Returns empty facts if they are unknown.
  VolumeFacts of(const DeviceVolume& volume) const;

 private:
  struct Entry {
    std::weak_ptr<const DeviceVolume> volume;
    VolumeFacts facts;
  };
  mutable std::mutex mutex_;
  std::map<const DeviceVolume*, Entry> entries_;
};

}  // namespace diaphane::render
