#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Controls a fake engine, with which tests force what is rare on a real one: any speed, refusals,
/// a lost device.
struct FakeDevice {
  std::atomic<double> seconds_per_megapixel{0.0};  ///< of one sample
  std::atomic<bool> refuse_scenes{false};
  std::atomic<std::uint32_t> refuse_wider_than{100000};
  std::atomic<bool> lost{false};
  std::atomic<bool> hangs{false};           ///< a quantum neither ends nor polls `stop`
  std::atomic<bool> holds_pictures{false};  ///< no picture becomes ready while this is set
  std::atomic<int> making_pictures{0};
  std::atomic<bool> refuse_renderers{false};  ///< as if there were no memory for another film
  std::atomic<std::uint64_t> samples{0};
  std::atomic<int> scenes{0};
  std::atomic<int> volumes{0};
  std::atomic<double> last_eye_x{0};
  std::atomic<double> helped_seconds{0};  ///< added to each batch as work done by other workers
  std::atomic<int> rendering{0};
  std::atomic<int> most_at_once{0};          ///< most renderers that rendered at once
  std::atomic<bool> one_at_a_time{false};    ///< renderers wait for each other, as on a full device
  std::atomic<unsigned> precedence{0};       ///< of the work begun last
  std::atomic<unsigned> raised_to{0};        ///< while it was in flight
  std::weak_ptr<const DeviceVolume> second;  ///< of the renderer that got one last
  volume::Matrix to_first{};
  std::mutex turn;
};

class FakeRenderer final : public FrameRenderer {
 public:
  FakeRenderer(std::shared_ptr<FakeDevice> device, std::shared_ptr<const DeviceVolume> volume)
      : device_(std::move(device)), volume_(std::move(volume)) {}

  Result<void> set_volume(std::shared_ptr<const DeviceVolume> volume) override {
    volume_ = std::move(volume);
    return {};
  }

  Result<void> set_second(std::shared_ptr<const DeviceVolume> volume,
                          const volume::Matrix& to_first) override {
    device_->second = volume;
    device_->to_first = to_first;
    return {};
  }

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override {
    if (device_->refuse_scenes || canvas.width > device_->refuse_wider_than) {
      return fail(ErrorCode::kOutOfMemory, "No memory for a picture of this size.");
    }
    ++device_->scenes;
    device_->last_eye_x = scene.camera().eye().x();
    shade_ = static_cast<std::uint8_t>(std::llround(scene.camera().eye().x()) & 255);
    canvas_ = canvas;
    progress_ = {};
    return {};
  }

  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override {
    using namespace std::chrono;
    const auto start = steady_clock::now();
    const int at_once = ++device_->rendering;
    for (int most = device_->most_at_once;
         most < at_once && !device_->most_at_once.compare_exchange_weak(most, at_once);) {
    }
    std::unique_lock turn(device_->turn, std::defer_lock);
    if (device_->one_at_a_time) turn.lock();
    const double cost = device_->seconds_per_megapixel * canvas_.width * canvas_.height / 1e6;
    Batch batch;
    while (device_->hangs) std::this_thread::sleep_for(milliseconds(1));
    for (; batch.samples < samples; ++batch.samples) {
      const auto end = steady_clock::now() + duration<double>(cost);
      while (steady_clock::now() < end && !stop()) std::this_thread::sleep_for(microseconds(500));
      if (steady_clock::now() < end || (cost == 0 && stop())) break;
    }
    --device_->rendering;
    if (device_->lost) return fail(ErrorCode::kDeviceLost, "the context is broken");
    batch.seconds = duration<double>(steady_clock::now() - start).count();
    batch.helped_seconds = device_->helped_seconds;
    device_->samples += batch.samples;
    progress_.samples += batch.samples;
    progress_.seconds += batch.seconds;
    return batch;
  }

  Progress progress() const override {
    Progress progress = progress_;
    progress.error = progress.samples < 2 ? std::numeric_limits<double>::infinity()
                                          : 0.5 / std::sqrt(double(progress.samples));
    return progress;
  }

  Result<void> display(PictureRgb8& out) override {
    ++device_->making_pictures;
    while (device_->holds_pictures) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --device_->making_pictures;
    out.size = canvas_;
    out.pixels.assign(std::size_t{3} * canvas_.width * canvas_.height, shade_);
    return {};
  }
  Result<void> radiance(PictureRgbF&) override {
    return fail(ErrorCode::kUnsupported, "not by the fake");
  }
  Result<void> contents(std::vector<std::uint8_t>&) override {
    return fail(ErrorCode::kUnsupported, "not by the fake");
  }
  void set_precedence(unsigned precedence) override { device_->precedence = precedence; }
  void raise_precedence(unsigned precedence) override { device_->raised_to = precedence; }
  void prepare_denoising(bool wanted) override { guided_ = wanted; }
  Result<bool> display_denoised(PictureRgb8& out) override {
    return display(out).map([this] { return guided_; });
  }
  std::vector<std::string> features() const override { return {}; }

 private:
  std::shared_ptr<FakeDevice> device_;
  std::shared_ptr<const DeviceVolume> volume_;
  Canvas canvas_;
  Progress progress_;
  std::uint8_t shade_ = 0;
  bool guided_ = false;
};

class FakeDeviceVolume final : public DeviceVolume {
 public:
  explicit FakeDeviceVolume(volume::Header header) : header_(std::move(header)) {}
  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override { return 2 * header_.voxel_count(); }

 private:
  volume::Header header_;
};

class FakeEngine final : public Engine {
 public:
  explicit FakeEngine(std::shared_ptr<FakeDevice> device) : device_(std::move(device)) {}
  EngineInfo info() const override { return {"fake", "a test", 1 << 30}; }
  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    ++device_->volumes;
    return std::make_shared<FakeDeviceVolume>(volume.header);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t, std::uint64_t,
                                                       Method) override {
    if (device_->refuse_renderers) return fail(ErrorCode::kOutOfMemory, "No memory for a film.");
    return std::make_unique<FakeRenderer>(device_, std::move(volume));
  }

  std::shared_ptr<FakeDevice> device_;
};

}  // namespace diaphane::render
