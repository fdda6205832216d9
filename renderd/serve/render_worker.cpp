#include "renderd/serve/render_worker.h"

#include <malloc.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "common/background.h"
#include "common/log.h"
#include "common/try.h"
#include "renderd/scene/texture_store.h"
#include "renderd/schedule/policy.h"
#include "renderd/schedule/visitor_share.h"
#include "renderd/session/host_volume.h"
#include "volume/labels.h"
#include "volume/slice_interpolation.h"
#include "volume/store.h"
#include "volume/volume.h"

namespace diaphane::render {
namespace {

/// Textures take at most a quarter of a core, because a session may change them as often as its
/// lights, and each of the largest takes 0.2 s.
constexpr double kTextureRest = 3;

/// Reads volumes from the store or from the node's copies.
struct Source {
  std::string store;
  std::shared_ptr<volume::NodeCache> copies;

  // Reads a phase of a volume, or its last phase if it has fewer. `id` was validated, so the path
  // cannot leave the store.
  Result<volume::Volume> read(const std::string& id, std::uint32_t phase) const {
    const std::string directory = store + "/" + id;
    if (phase > 0) {
      const auto header = volume::read_header(directory);
      DIAPHANE_TRY(header);
      phase = std::min(phase, header->phase_count() - 1);
    }
    return copies ? copies->read(id, phase) : volume::read(directory, false, phase);
  }
};

Result<VolumeCache::Handle> load_volume(Engine& engine, VolumeStatsCache& stats,
                                        const Source& source, const VolumeKey& key) {
  const auto start = std::chrono::steady_clock::now();
  const std::string& id = key.id;
  auto volume = source.read(id, key.phase);
  DIAPHANE_TRY(volume);
  const std::uint32_t refinement = volume::refinement_of(volume->header);
  std::optional<volume::Volume> copy;
  // The node keeps the voxels as they are in the store.
  const bool changes = !key.with_table || refinement > 1;
  volume::LabelSet stored_labels = volume->label_set;
  if (changes && source.copies && source.copies->misses(*volume)) copy = *volume;
  if (!key.with_table) {
    if (const auto hidden = volume::hide_surroundings(*volume); !hidden) {
      log::warning("labels_damaged", {{"volume", id}, {"reason", hidden.error().message}});
    }
  }
  volume::list_found_labels(*volume);
  VolumeStats of_stored = stats_of(*volume);
  volume::widen_dense_parts(*volume);
  of_stored.coarse = coarse_of(*volume);
  volume::refine_slices(*volume, refinement, std::thread::hardware_concurrency());
  auto loaded = engine.load(*volume);
  if (loaded) stats.add(*loaded, std::move(of_stored));
  const auto seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  log::info("volume_loaded", {{"volume", id}, {"ok", loaded.has_value()}, {"seconds", seconds}});
  if (source.copies && copy) source.copies->keep(std::move(*copy));
  if (source.copies && !changes) {
    volume->label_set = std::move(stored_labels);
    source.copies->keep(std::move(*volume));
  }
  return loaded;
}

Result<VolumeCache::Handle> load_voxels(const Source& source, const VolumeKey& key) {
  auto volume = source.read(key.id, key.phase);
  DIAPHANE_TRY(volume);
  // The label set must be the one that viewers receive with the names.
  volume::list_found_labels(*volume);
  return std::make_shared<const HostVolume>(std::move(*volume));
}

std::unique_ptr<Policy> policy_of(const RenderWorker::Options& options) {
  return std::make_unique<VisitorShare>(make_policy(options.policy),
                                        options.host.visitor_percent / 100.0);
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
    : metrics_(metrics),
      copies_(options.copies),
      engine_(std::move(engine)),
      homes_(std::make_unique<Homes>(*engine_,
                                     [&options, &clock](const Engine& device) {
                                       return std::make_unique<Runner>(
                                           policy_of(options), clock,
                                           with_device(options.runner, device));
                                     })),
      encoders_(std::make_unique<EncodePool>(options.encoder_threads)),
      volumes_(std::make_unique<VolumeCache>(
          [this, source = Source{options.volume_dir, options.copies}](const VolumeKey& key) {
            return load_volume(*engine_, stats_, source, key);
          },
          options.volume_bytes, 1,
          [store = options.volume_dir](const std::string& id) {
            return volume::stored_version(store + "/" + id);
          })),
      slicers_(std::make_unique<EncodePool>(1)),
      textures_(std::make_unique<EncodePool>(1, kTextureRest)),
      voxels_(std::make_unique<VolumeCache>(
          [source = Source{options.volume_dir, options.copies}](const VolumeKey& key) {
            return load_voxels(source, key);
          },
          options.volume_bytes, 1,
          [store = options.volume_dir](const std::string& id) {
            return volume::stored_version(store + "/" + id);
          })),
      host_(std::make_unique<SessionHost>(with_reclaim(options.host), *homes_, *encoders_,
                                          *volumes_, stats_, SliceParts{*voxels_, *slicers_},
                                          *textures_, metrics, clock)),
      stills_(std::make_unique<StillService>(*homes_, *encoders_, *volumes_, stats_, metrics, clock,
                                             options.still_samples)),
      assists_(std::make_unique<AssistHost>(
          AssistHost::Options{.most = options.host.slots, .spare_bytes = options.volume_bytes / 2},
          *homes_, *volumes_)),
      watching_([this](const std::stop_token& stop) { watch_store(stop); }) {
  slow_down_decoding();
}

SessionHost::Options RenderWorker::with_reclaim(SessionHost::Options options) {
  options.reclaim = [this] { return assists_ && assists_->end_spare(); };
  return options;
}

void RenderWorker::slow_down_decoding() {
  // On Linux the priority is per thread. With few cores, rendering takes precedence over decoding
  // textures.
  constexpr int kNice = 10;
  textures_->post(EncodePool::Urgency::kLater, [] { background::enter(kNice); });
}

void RenderWorker::watch_store(const std::stop_token& stop) {
  constexpr std::chrono::seconds kPeriod{1};
  constexpr std::size_t kWorthTrimming = std::size_t{16} << 20;
  std::mutex mutex;
  std::condition_variable_any changed;
  std::unique_lock lock(mutex);
  while (!changed.wait_for(lock, stop, kPeriod, [] { return false; }) && !stop.stop_requested()) {
    for (const VolumeCache::Outdated& volume : volumes_->forget_outdated()) {
      log::info("volume_unloaded", {{"volume", volume.id}, {"labels", volume.only_labels}});
      volume.only_labels ? host_->labels_changed(volume.id) : host_->volume_gone(volume.id);
    }
    voxels_->forget_unused();
    stats_.forget_expired();
    // Part of the texture memory is on the heap, which does not return freed memory by itself.
    if (take_freed_texture_memory() >= kWorthTrimming) malloc_trim(0);
    if (copies_) metrics_.volume_copies(copies_->counts());
  }
}

void RenderWorker::stop() {
  host_->end_all();
  assists_->end_all();
  homes_->stop();
}

RenderWorker::~RenderWorker() {
  watching_ = {};
  stop();
  // Loading or encoding in progress may still call a runner, so the runners are destroyed last.
  volumes_.reset();
  slicers_.reset();
  textures_.reset();
  voxels_.reset();
  encoders_.reset();
  homes_.reset();
}

}  // namespace diaphane::render
