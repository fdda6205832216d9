#include "bench/renderer/device_process.h"

#include "common/try.h"

namespace diaphane::render::bench {
namespace {

/// The device of one process and its renderer.
class DeviceProcess {
 public:
  DeviceProcess(EngineChoice choice, unsigned threads, const volume::Volume& volume) {
    auto engine = make_engine(choice, threads);
    if (!engine) {
      trouble_ = engine.error();
      return;
    }
    engine_ = *std::move(engine);
    auto loaded = engine_->load(volume);
    if (!loaded) {
      trouble_ = loaded.error();
      return;
    }
    volume_ = *std::move(loaded);
  }

  Result<std::string> answer(ProcessMessageKind word, std::string_view payload) {
    if (!volume_) return tl::unexpected(trouble_);
    if (word == ProcessMessageKind::kInfo) {
      const EngineInfo info = engine_->info();
      return info.engine + "\n" + info.device;
    }
    if (word == ProcessMessageKind::kRenderer) return make(unpacked<RendererOptions>(payload));
    if (!renderer_) return fail(ErrorCode::kInternal, "there is no renderer yet");
    switch (word) {
      case ProcessMessageKind::kScene:
        return set_scene(payload);
      case ProcessMessageKind::kRender:
        return render(unpacked<std::uint32_t>(payload));
      case ProcessMessageKind::kProgress:
        return packed(renderer_->progress());
      case ProcessMessageKind::kRadiance:
        return radiance();
      case ProcessMessageKind::kContents:
        return contents();
      case ProcessMessageKind::kFeatures:
        return features();
      default:
        return fail(ErrorCode::kInternal, "the device process received an unknown command");
    }
  }

 private:
  Result<std::string> make(const RendererOptions& options) {
    renderer_.reset();
    auto renderer = engine_->renderer(volume_, options.seed, options.first_sample, options.method);
    DIAPHANE_TRY(renderer);
    renderer_ = *std::move(renderer);
    return std::string();
  }
  Result<std::string> set_scene(std::string_view payload) {
    const auto canvas = unpacked<Canvas>(payload);
    diaphane::v1::Scene scene;
    if (!scene.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
      return fail(ErrorCode::kInternal, "the device process did not receive a scene");
    }
    DIAPHANE_TRY(renderer_->set_scene(scene, canvas));
    return std::string();
  }
  Result<std::string> render(std::uint32_t samples) {
    auto batch = renderer_->render(samples, [] { return false; });
    DIAPHANE_TRY(batch);
    return packed(*batch);
  }
  Result<std::string> radiance() {
    PictureRgbF picture;
    DIAPHANE_TRY(renderer_->radiance(picture));
    return std::string(reinterpret_cast<const char*>(picture.pixels.data()),
                       picture.pixels.size() * sizeof picture.pixels[0]);
  }
  Result<std::string> contents() {
    std::vector<std::uint8_t> met;
    DIAPHANE_TRY(renderer_->contents(met));
    return std::string(met.begin(), met.end());
  }
  Result<std::string> features() {
    std::string names;
    for (const std::string& name : renderer_->features()) names += name + "\n";
    return names;
  }

  std::unique_ptr<Engine> engine_;
  std::shared_ptr<const DeviceVolume> volume_;
  std::unique_ptr<FrameRenderer> renderer_;
  Error trouble_;
};

}  // namespace

void serve_device_process(const ProcessWire& wire, EngineChoice choice, unsigned threads,
                          const volume::Volume& volume) {
  DeviceProcess device(choice, threads, volume);
  while (auto request = wire.receive()) {
    const auto answer = device.answer(request->word, request->payload);
    const bool sent = answer ? wire.send(ProcessMessageKind::kDone, *answer)
                             : wire.send(ProcessMessageKind::kFailed,
                                         packed(answer.error().code) + answer.error().message);
    if (!sent) return;
  }
}

}  // namespace diaphane::render::bench
