#pragma once

#include <utility>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// A volume's voxels in host memory, independent of the device. Slices are read from it.
class HostVolume final : public DeviceVolume {
 public:
  explicit HostVolume(volume::Volume volume) : volume_(std::move(volume)) {}
  const volume::Header& header() const override { return volume_.header; }
  std::uint64_t device_bytes() const override {
    return volume_.voxels.size() * sizeof(volume_.voxels[0]);
  }
  const volume::Volume& volume() const { return volume_; }

 private:
  volume::Volume volume_;
};

}  // namespace diaphane::render
