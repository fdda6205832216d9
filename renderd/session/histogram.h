#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "api/proto/stream.pb.h"
#include "renderd/engine/frame_renderer.h"
#include "volume/volume.h"

namespace diaphane::render {

/// How often values occur, by every n-th voxel, four million at most: up to 256 bins, none narrower
/// than 1, so that none stands empty between two integers. What lies outside of the header's
/// minimum and maximum is padding, and left out.
diaphane::v1::Histogram histogram_of(const volume::Volume& volume);

/// The histograms of the volumes on a device, each as long as somebody holds its volume.
/// Thread-safe.
class Histograms {
 public:
  void add(const std::shared_ptr<const DeviceVolume>& volume, diaphane::v1::Histogram histogram);
  /// Empty when it is not known.
  diaphane::v1::Histogram of(const DeviceVolume& volume) const;

 private:
  struct Entry {
    std::weak_ptr<const DeviceVolume> volume;
    diaphane::v1::Histogram histogram;
  };
  mutable std::mutex mutex_;
  std::map<const DeviceVolume*, Entry> entries_;
};

}  // namespace diaphane::render
