#include "renderd/composite/composite_engine.h"

#include <algorithm>
#include <future>
#include <utility>

#include "common/try.h"
#include "renderd/composite/composite_volume.h"
#include "renderd/composite/device_thread.h"

namespace diaphane::render {
namespace {

/// Loads a volume on all devices at once.
Result<std::vector<std::shared_ptr<const DeviceVolume>>> load_on_all(
    const std::vector<std::unique_ptr<Engine>>& devices, const volume::Volume& volume) {
  std::vector<std::future<Result<std::shared_ptr<const DeviceVolume>>>> loading;
  for (std::size_t d = 1; d < devices.size(); ++d) {
    loading.push_back(std::async(std::launch::async, [&, d] { return devices[d]->load(volume); }));
  }
  std::vector<Result<std::shared_ptr<const DeviceVolume>>> loaded;
  loaded.push_back(devices.front()->load(volume));
  for (auto& one : loading) loaded.push_back(one.get());
  std::vector<std::shared_ptr<const DeviceVolume>> copies;
  for (auto& one : loaded) {
    DIAPHANE_TRY(one);
    copies.push_back(std::move(*one));
  }
  return copies;
}

class Devices;

/// The devices with one of them as the home of all pictures.
class Home final : public Engine {
 public:
  Home(Devices& devices, std::size_t device) : devices_(devices), device_(device) {}
  EngineInfo info() const override;
  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override;
  Result<std::unique_ptr<FrameRenderer>> alone(const std::shared_ptr<const DeviceVolume>& volume,
                                               std::uint64_t seed, std::uint64_t first_sample,
                                               Method method);

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override;
  Devices& devices_;
  const std::size_t device_;
};

class Devices final : public CompositeEngine {
 public:
  Devices(std::vector<std::unique_ptr<Engine>> devices, AssistSource* source,
          CompositeOptions options)
      : devices_(std::move(devices)), source_(source), options_(options) {
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      homes_.push_back(std::make_unique<Home>(*this, d));
      threads_.push_back(devices_.size() > 1 ? std::make_unique<DeviceThread>() : nullptr);
    }
  }

  std::size_t devices() const override { return devices_.size(); }
  Engine& home(std::size_t device) override { return *homes_.at(device); }
  void keep_for_own(std::function<bool(std::size_t)> needed) override {
    for (std::size_t d = 0; d < threads_.size(); ++d) {
      if (!threads_[d]) continue;
      threads_[d]->keep_for_own(needed ? [needed, d] { return needed(d); }
                                       : std::function<bool()>());
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
    auto copies = load_on_all(devices_, volume);
    DIAPHANE_TRY(copies);
    return std::make_shared<CompositeVolume>(volume, *std::move(copies));
  }

  Result<std::unique_ptr<FrameRenderer>> alone(const std::shared_ptr<const DeviceVolume>& volume,
                                               std::size_t device, std::uint64_t seed,
                                               std::uint64_t first_sample, Method method) {
    const auto ours = std::dynamic_pointer_cast<const CompositeVolume>(volume);
    if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    return devices_[device]->renderer(ours->copy(device), seed, first_sample, method);
  }

  Result<std::unique_ptr<FrameRenderer>> together(std::shared_ptr<const DeviceVolume> volume,
                                                  std::size_t home, std::uint64_t seed,
                                                  std::uint64_t first_sample, Method method) {
    const auto ours = std::dynamic_pointer_cast<const CompositeVolume>(std::move(volume));
    if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    // Parts of a draft are not merged, so a draft would show the work of the home device alone.
    if (method.walk == Walk::kDraft) method.walk = Walk::kSoonest;
    auto own = alone(ours, home, seed, first_sample, method);
    if (!own) return own;
    std::vector<std::unique_ptr<Assistant>> assistants;
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      if (d == home) continue;
      auto other = alone(ours, d, seed, first_sample, method);
      if (!other) return other;
      assistants.push_back(threads_[d]->assistant(std::move(*other), d));
    }
    if (source_ != nullptr && !ours->id().empty()) {
      for (auto& one : source_->assistants(
               {ours->id(), ours->with_table(), ours->phase(), seed, first_sample, method})) {
        assistants.push_back(std::move(one));
      }
    }
    return std::make_unique<CompositeRenderer>(*std::move(own), std::move(assistants), options_,
                                               home);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    return together(std::move(volume), 0, seed, first_sample, method);
  }

  const std::vector<std::unique_ptr<Engine>> devices_;
  std::vector<std::unique_ptr<Home>> homes_;
  std::vector<std::unique_ptr<DeviceThread>> threads_;  ///< destroyed before the devices
  AssistSource* const source_;
  const CompositeOptions options_;
};

EngineInfo Home::info() const { return devices_.info(); }

Result<std::shared_ptr<const DeviceVolume>> Home::load(const volume::Volume& volume) {
  return devices_.load(volume);
}

Result<std::unique_ptr<FrameRenderer>> Home::alone(
    const std::shared_ptr<const DeviceVolume>& volume, std::uint64_t seed,
    std::uint64_t first_sample, Method method) {
  return devices_.alone(volume, device_, seed, first_sample, method);
}

Result<std::unique_ptr<FrameRenderer>> Home::make_renderer(
    std::shared_ptr<const DeviceVolume> volume, std::uint64_t seed, std::uint64_t first_sample,
    Method method) {
  return devices_.together(std::move(volume), device_, seed, first_sample, method);
}

}  // namespace

std::unique_ptr<CompositeEngine> make_composite_engine(std::vector<std::unique_ptr<Engine>> devices,
                                                       AssistSource* source,
                                                       CompositeOptions options) {
  return std::make_unique<Devices>(std::move(devices), source, options);
}

Result<std::unique_ptr<FrameRenderer>> renderer_of_one_device(
    Engine& engine, const std::shared_ptr<const DeviceVolume>& volume, std::uint64_t seed,
    std::uint64_t first_sample, Method method) {
  if (auto* home = dynamic_cast<Home*>(&engine)) {
    return home->alone(volume, seed, first_sample, method);
  }
  if (auto* devices = dynamic_cast<Devices*>(&engine)) {
    return devices->alone(volume, 0, seed, first_sample, method);
  }
  return engine.renderer(volume, seed, first_sample, method);
}

}  // namespace diaphane::render
