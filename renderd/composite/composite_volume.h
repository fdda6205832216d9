#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// One copy of the volume on each device.
class CompositeVolume final : public DeviceVolume {
 public:
  CompositeVolume(const volume::Volume& volume,
                  std::vector<std::shared_ptr<const DeviceVolume>> copies)
      : id_(volume.id),
        with_table_(!volume.surroundings_hidden),
        phase_(volume.phase),
        copies_(std::move(copies)) {}
  const volume::Header& header() const override { return copies_.front()->header(); }
  /// Returns the bytes on the device where it takes most, because each device has its own memory.
  std::uint64_t device_bytes() const override {
    std::uint64_t most = 0;
    for (const auto& copy : copies_) most = std::max(most, copy->device_bytes());
    return most;
  }
  const std::string& id() const { return id_; }
  bool with_table() const { return with_table_; }
  std::uint32_t phase() const { return phase_; }
  const std::shared_ptr<const DeviceVolume>& copy(std::size_t device) const {
    return copies_[device];
  }

 private:
  std::string id_;
  bool with_table_;
  std::uint32_t phase_;
  std::vector<std::shared_ptr<const DeviceVolume>> copies_;
};

}  // namespace diaphane::render
