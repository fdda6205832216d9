#include "renderd/composite/composite_engine.h"

#include <algorithm>
#include <utility>

#include "renderd/composite/device_thread.h"

namespace diaphane::render {
namespace {

/// One copy of the volume on each device.
class CompositeVolume final : public DeviceVolume {
 public:
  CompositeVolume(const volume::Volume& volume,
                  std::vector<std::shared_ptr<const DeviceVolume>> copies)
      : id_(volume.id), with_table_(!volume.surroundings_hidden), copies_(std::move(copies)) {}
  const volume::Header& header() const override { return copies_.front()->header(); }
  /// The bytes on the device where it takes most, because each device has its own memory.
  std::uint64_t device_bytes() const override {
    std::uint64_t most = 0;
    for (const auto& copy : copies_) most = std::max(most, copy->device_bytes());
    return most;
  }
  const std::string& id() const { return id_; }
  bool with_table() const { return with_table_; }
  const std::shared_ptr<const DeviceVolume>& copy(std::size_t device) const {
    return copies_[device];
  }

 private:
  std::string id_;
  bool with_table_;
  std::vector<std::shared_ptr<const DeviceVolume>> copies_;
};

class CompositeEngine final : public Engine {
 public:
  CompositeEngine(std::vector<std::unique_ptr<Engine>> devices, AssistSource* source,
                  CompositeOptions options)
      : devices_(std::move(devices)), source_(source), options_(options) {
    for (std::size_t d = 1; d < devices_.size(); ++d) {
      threads_.push_back(std::make_unique<DeviceThread>());
    }
  }

  EngineInfo info() const override {
    EngineInfo info = devices_.front()->info();
    if (devices_.size() > 1) info.device = std::to_string(devices_.size()) + " x " + info.device;
    for (const auto& device : devices_) {
      info.memory_bytes = std::min(info.memory_bytes, device->info().memory_bytes);
    }
    return info;
  }

  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    std::vector<std::shared_ptr<const DeviceVolume>> copies;
    for (const auto& device : devices_) {
      auto copy = device->load(volume);
      if (!copy) return copy;
      copies.push_back(std::move(*copy));
    }
    return std::make_shared<CompositeVolume>(volume, std::move(copies));
  }

  Result<std::unique_ptr<FrameRenderer>> of_first(const std::shared_ptr<const DeviceVolume>& volume,
                                                  std::uint64_t seed, std::uint64_t first_sample,
                                                  Method method) {
    const auto ours = std::dynamic_pointer_cast<const CompositeVolume>(volume);
    if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    return devices_.front()->renderer(ours->copy(0), seed, first_sample, method);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    const auto ours = std::dynamic_pointer_cast<const CompositeVolume>(std::move(volume));
    if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    // A draft is not merged, and would be one device's alone.
    if (method.walk == Walk::kDraft) method.walk = Walk::kSoonest;
    auto own = devices_.front()->renderer(ours->copy(0), seed, first_sample, method);
    if (!own) return own;
    std::vector<std::unique_ptr<Assistant>> assistants;
    for (std::size_t d = 1; d < devices_.size(); ++d) {
      auto other = devices_[d]->renderer(ours->copy(d), seed, first_sample, method);
      if (!other) return other;
      assistants.push_back(threads_[d - 1]->assistant(std::move(*other)));
    }
    if (source_ != nullptr && !ours->id().empty()) {
      for (auto& one :
           source_->assistants({ours->id(), ours->with_table(), seed, first_sample, method})) {
        assistants.push_back(std::move(one));
      }
    }
    return std::make_unique<CompositeRenderer>(*std::move(own), std::move(assistants), options_);
  }

  const std::vector<std::unique_ptr<Engine>> devices_;
  std::vector<std::unique_ptr<DeviceThread>> threads_;  ///< destroyed before the devices
  AssistSource* const source_;
  const CompositeOptions options_;
};

}  // namespace

std::unique_ptr<Engine> make_composite_engine(std::vector<std::unique_ptr<Engine>> devices,
                                              AssistSource* source, CompositeOptions options) {
  return std::make_unique<CompositeEngine>(std::move(devices), source, options);
}

Result<std::unique_ptr<FrameRenderer>> renderer_of_one_device(
    Engine& engine, const std::shared_ptr<const DeviceVolume>& volume, std::uint64_t seed,
    std::uint64_t first_sample, Method method) {
  if (auto* composite = dynamic_cast<CompositeEngine*>(&engine)) {
    return composite->of_first(volume, seed, first_sample, method);
  }
  return engine.renderer(volume, seed, first_sample, method);
}

}  // namespace diaphane::render
