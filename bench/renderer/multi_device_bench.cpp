#include "bench/renderer/multi_device_bench.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "bench/renderer/timing.h"
#include "common/try.h"

namespace diaphane::render::bench {
namespace {

/// Renders a fixed number of passes of its task, once.
class PassesAssistant final : public Assistant {
 public:
  PassesAssistant(std::unique_ptr<FrameRenderer> renderer, std::uint32_t passes)
      : renderer_(std::move(renderer)), passes_(passes) {}
  void begin(const AssistTask& task) override {
    epoch_ = task.epoch;
    ready_ = renderer_->set_scene(*task.scene, task.canvas) && renderer_->set_share(task.share) &&
             renderer_->render(passes_, [] { return false; });
    lost_ = !ready_;
  }
  std::optional<AssistPart> take(const AssistNews&) override {
    if (!std::exchange(ready_, false)) return std::nullopt;
    AssistPart part;
    part.epoch = epoch_;
    const auto taken = renderer_->take_film(part.film);
    lost_ = !taken || !*taken;
    if (lost_) return std::nullopt;
    return part;
  }
  bool lost() override { return lost_; }

 private:
  std::unique_ptr<FrameRenderer> renderer_;
  std::uint32_t passes_;
  std::uint64_t epoch_ = 0;
  bool ready_ = false, lost_ = false;
};

/// Returns the picture of `count` devices that each rendered `passes`.
Result<std::unique_ptr<CompositeRenderer>> composited(const DeviceSet& devices,
                                                      const Subject& subject, unsigned count,
                                                      std::uint32_t passes, std::uint64_t seed,
                                                      Method method) {
  std::vector<std::unique_ptr<FrameRenderer>> renderers;
  for (unsigned d = 0; d < count; ++d) {
    auto made = devices.engines[d]->renderer(devices.volumes[d], seed, 0, method);
    DIAPHANE_TRY(made);
    renderers.push_back(std::move(*made));
  }
  std::vector<std::unique_ptr<Assistant>> assistants;
  for (unsigned d = 1; d < count; ++d) {
    assistants.push_back(std::make_unique<PassesAssistant>(std::move(renderers[d]), passes));
  }
  auto many = std::make_unique<CompositeRenderer>(std::move(renderers[0]), std::move(assistants),
                                                  CompositeOptions{.division = Division::kAverage});
  DIAPHANE_TRY(many->set_scene(subject.scene, subject.canvas));
  const auto batch = many->render(passes, [] { return false; });
  DIAPHANE_TRY(batch);
  if (many->progress().samples != std::uint64_t{count} * passes) {
    return fail(ErrorCode::kInternal, "a device did not deliver its passes");
  }
  return many;
}

}  // namespace

Result<DeviceSet> open_devices(EngineChoice choice, unsigned count, unsigned threads,
                               const volume::Volume& volume) {
  auto options = engine_options_from_environment();
  DIAPHANE_TRY(options);
  if (threads == 0) threads = std::thread::hardware_concurrency();
  DeviceSet devices;
  for (unsigned d = 0; d < count; ++d) {
    options->device = static_cast<int>(d);
    auto engine = make_engine(choice, std::max(1U, threads / count), *options);
    DIAPHANE_TRY(engine);
    auto loaded = (*engine)->load(volume);
    DIAPHANE_TRY(loaded);
    devices.engines.push_back(std::move(*engine));
    devices.volumes.push_back(std::move(*loaded));
  }
  return devices;
}

Result<std::vector<ErrorRow>> measure_errors(const DeviceSet& devices, const Subject& subject,
                                             const Reference& reference,
                                             const ErrorOptions& options) {
  std::vector<ErrorRow> rows;
  for (const bool low_discrepancy : {false, true}) {
    for (const std::uint32_t passes : options.passes) {
      double one = 0;
      for (const unsigned count : options.devices) {
        ErrorRow row{passes, count, low_discrepancy, 0, 0, 0};
        double squared = 0, estimated = 0;
        for (std::uint32_t repeat = 0; repeat < options.repeats; ++repeat) {
          auto many = composited(devices, subject, count, passes, 1 + repeat,
                                 {.walk = options.walk, .low_discrepancy = low_discrepancy});
          DIAPHANE_TRY(many);
          PictureRgbF picture;
          DIAPHANE_TRY((*many)->radiance(picture));
          squared += std::pow(error_against(reference, picture).rmse, 2);
          estimated += std::pow((*many)->progress().error, 2);
        }
        row.rmse = without_noise_of(reference, std::sqrt(squared / options.repeats));
        row.estimate = std::sqrt(estimated / options.repeats);
        if (count == 1) one = row.rmse;
        row.off = one > 0 ? row.rmse / one * std::sqrt(double(count)) - 1 : 0;
        rows.push_back(row);
      }
    }
  }
  return rows;
}

Result<PictureRgb8> side_by_side(const DeviceSet& devices, const Subject& subject, unsigned count,
                                 const std::vector<std::uint32_t>& passes) {
  const Canvas one = subject.canvas;
  PictureRgb8 all;
  all.size = {2 * one.width, static_cast<std::uint32_t>(passes.size()) * one.height};
  all.pixels.resize(std::size_t{3} * all.size.width * all.size.height);
  for (std::size_t i = 0; i < passes.size(); ++i) {
    for (const unsigned right : {0U, 1U}) {
      auto many = composited(devices, subject, right == 1 ? count : 1, passes[i], 1, {});
      DIAPHANE_TRY(many);
      PictureRgb8 picture;
      DIAPHANE_TRY((*many)->display(picture));
      for (std::uint32_t y = 0; y < one.height; ++y) {
        std::copy_n(&picture.pixels[std::size_t{3} * one.width * y], std::size_t{3} * one.width,
                    &all.pixels[3 * (std::size_t{right} * one.width +
                                     all.size.width * (i * one.height + y))]);
      }
    }
  }
  return all;
}

}  // namespace diaphane::render::bench
