#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "api/proto/stream.pb.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/session/depth.h"

namespace diaphane::render {

/// What is found out of a volume when it is loaded.
struct VolumeFacts {
  diaphane::v1::Histogram histogram;
  std::shared_ptr<const CoarseVolume> coarse;
};
VolumeFacts facts_of(const volume::Volume& volume);

/// The facts of the volumes on a device, each as long as somebody holds its volume. Thread-safe.
class KeptFacts {
 public:
  void add(const std::shared_ptr<const DeviceVolume>& volume, VolumeFacts facts);
  /// Drops the facts of volumes that nobody holds any more: the coarse copy of a small volume has
  /// every voxel of it. To be called now and then.
  void forget_expired();
  /// Empty when they are not known.
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
