#include "renderd/serve/render_worker.h"

#include "common/log.h"
#include "renderd/schedule/policy.h"

namespace diaphane::render {
namespace {

// `id` has been checked to be an id, so it cannot lead out of the store.
Result<VolumeCache::Handle> load_volume(Engine& engine, const std::string& store,
                                        const std::string& id) {
  const auto start = std::chrono::steady_clock::now();
  const auto volume = volume::read(store + "/" + id, false);
  if (!volume) return tl::unexpected(volume.error());
  auto loaded = engine.load(*volume);
  const auto seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  log::info("volume_loaded", {{"volume", id}, {"ok", loaded.has_value()}, {"seconds", seconds}});
  return loaded;
}

Runner::Options with_device(Runner::Options options, const Engine& engine) {
  const EngineInfo info = engine.info();
  options.rules.device_parallel = info.parallel;
  options.device_queues = info.queues;
  return options;
}

}  // namespace

RenderWorker::RenderWorker(Options options, std::unique_ptr<Engine> engine, Metrics& metrics,
                           const Clock& clock)
    : engine_(std::move(engine)),
      runner_(std::make_unique<Runner>(make_policy(options.policy), clock,
                                       with_device(options.runner, *engine_))),
      encoders_(std::make_unique<EncodePool>(options.encoder_threads)),
      volumes_(std::make_unique<VolumeCache>(
          [this, store = options.volume_dir](const std::string& id) {
            return load_volume(*engine_, store, id);
          },
          options.volume_bytes)),
      host_(std::make_unique<SessionHost>(options.host, *engine_, *runner_, *encoders_, *volumes_,
                                          metrics, clock)),
      stills_(std::make_unique<StillService>(*engine_, *runner_, *encoders_, *volumes_, metrics,
                                             clock)),
      assists_(std::make_unique<AssistHost>(AssistHost::Options{options.host.slots}, *engine_,
                                            *runner_, *volumes_)) {}

void RenderWorker::stop() {
  host_->end_all();
  assists_->end_all();
  runner_->stop();
}

RenderWorker::~RenderWorker() {
  stop();
  // A load or a coding under way still ends in a call to the runner, which only its end forbids.
  volumes_.reset();
  encoders_.reset();
  runner_.reset();
}

}  // namespace diaphane::render
