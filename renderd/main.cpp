// Entry point of renderd: connects the parts and handles signals.

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "common/clock.h"
#include "common/config.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/service/admin_server.h"
#include "common/service/core_files.h"
#include "common/service/freed_memory.h"
#include "common/service/signals.h"
#include "common/try.h"
#include "directory/client.h"
#include "renderd/composite/composite_engine.h"
#include "renderd/scene/environment_store.h"
#include "renderd/scene/texture_store.h"
#include "renderd/serve/capacity_broker.h"
#include "renderd/serve/grpc_assistants.h"
#include "renderd/serve/grpc_server.h"
#include "renderd/serve/registry.h"
#include "renderd/serve/render_worker.h"
#include "renderd/serve/watchdog.h"
#include "renderd/settings.h"
#include "volume/node_cache.h"
#include "volume/store.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;

constexpr int kExitUnavailable = 69;  // sysexits.h: EX_UNAVAILABLE
constexpr int kExitDevice = 70;       // EX_SOFTWARE: the device's context is broken

void log_fallback(const Error& reason) {
  log::warning("cuda_not_used", {{"code", to_string(reason.code)}, {"message", reason.message}});
}

/// Makes the engines of all devices that this process sees and can use; none without a usable GPU.
std::vector<std::unique_ptr<Engine>> engines_of_all_devices(const Settings& settings) {
  std::vector<std::unique_ptr<Engine>> engines;
  if (settings.engine == EngineChoice::kCpu) return engines;
  for (int device = 0; device < visible_devices(); ++device) {
    EngineOptions options = settings.options;
    options.device = device;
    auto engine = make_engine(EngineChoice::kCuda, 0, options);
    if (engine) {
      engines.push_back(std::move(*engine));
    } else {
      log::warning("device_left_out", {{"device", device}, {"message", engine.error().message}});
    }
  }
  return engines;
}

Result<std::vector<std::unique_ptr<Engine>>> engines_of(const Settings& settings) {
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<int> devices = settings.devices;
  if (devices.empty()) {
    engines = engines_of_all_devices(settings);
    if (!engines.empty()) return engines;
    devices = {0};
  }
  const auto count = static_cast<unsigned>(devices.size());
  const unsigned cores =
      settings.threads > 0 ? settings.threads : std::thread::hardware_concurrency();
  for (const int device : devices) {
    EngineOptions options = settings.options;
    options.device = device;
    auto engine =
        make_engine(settings.engine, count > 1 ? std::max(1U, cores / count) : settings.threads,
                    options, log_fallback);
    DIAPHANE_TRY(engine);
    engines.push_back(std::move(*engine));
  }
  return engines;
}

/// Returns a single device as it is, and several devices or assistants as one composite.
Result<std::unique_ptr<Engine>> engine_of(const Settings& settings, AssistSource* source) {
  auto engines = engines_of(settings);
  DIAPHANE_TRY(engines);
  if (engines->size() == 1 && source == nullptr) return std::move(engines->front());
  return make_composite_engine(*std::move(engines), source);
}

// Opens the node's copies of volumes, or returns null. Without copies, everything works, but
// slowly.
std::shared_ptr<volume::NodeCache> copies_of(const Settings& settings) {
  if (settings.copies_dir.empty()) return {};
  auto copies = volume::NodeCache::open({.folder = settings.copies_dir,
                                         .bound = settings.copies_bytes,
                                         .store = settings.volume_dir});
  if (copies) return std::move(*copies);
  log::warning("no_volume_copies",
               {{"folder", settings.copies_dir}, {"message", copies.error().message}});
  return {};
}

// Ends the process, which can no longer use the device. Redis already has its sessions' scenes.
[[noreturn]] void leave_broken_device(const Error& why) {
  log::error("device_lost", {{"message", why.message}});
  std::_Exit(kExitDevice);
}

// Ends the process because something hangs, which makes an orderly shutdown impossible. Connections
// and heartbeats end with the process, and its supervisor restarts it. Its sessions are placed
// again with the scenes that are in Redis.
[[noreturn]] void leave_hung(const std::string& what) {
  log::error("hung", {{"what", what}});
  std::_Exit(kExitDevice);
}

// Limits the time of an orderly shutdown, for example while a volume is read from a slow disk.
void end_within(milliseconds limit) {
  std::thread([limit] {
    std::this_thread::sleep_for(limit);
    log::warning("drain_cut_short");
    std::_Exit(0);
  }).detach();
}

// The parts that the operations port describes, null before serving and during shutdown.
struct Observed {
  std::atomic<RenderWorker*> worker{nullptr};
  std::atomic<Registry*> registry{nullptr};
  std::atomic<const Watchdog*> watchdog{nullptr};
};

Result<std::unique_ptr<service::AdminServer>> start_admin(const Settings& settings,
                                                          const EngineInfo& info,
                                                          const Observed& observed) {
  service::AdminServer::Options options = settings.admin;
  options.checks = {{"redis",
                     [&] {
                       const Registry* registry = observed.registry;
                       return registry && registry->connected();
                     }},
                    {"watchdog",
                     [&] {
                       const Watchdog* watchdog = observed.watchdog;
                       return !watchdog || !watchdog->suspects();
                     }},
                    {"volume store", [dir = settings.volume_dir] {
                       return access(dir.c_str(), R_OK | X_OK) == 0;
                     }}};
  options.details = [&] {
    RenderWorker* worker = observed.worker;
    return nlohmann::json{{"engine", info.engine},
                          {"device", info.device},
                          {"slots", settings.slots},
                          {"used", worker ? worker->host().used() : 0}}
        .dump();
  };
  return service::AdminServer::start(std::move(options));
}

RenderWorker::Options worker_options(const Settings& settings, const EngineInfo& info) {
  RenderWorker::Options options;
  options.volume_dir = settings.volume_dir;
  options.copies = copies_of(settings);
  if (settings.volume_bytes > 0) {
    options.volume_bytes = settings.volume_bytes;
  } else if (info.memory_bytes > 0) {
    options.volume_bytes = info.memory_bytes / 2;
  }
  // A GPU leaves the processor to the encoders, while the CPU engine needs it itself.
  const unsigned cores = std::thread::hardware_concurrency();
  options.encoder_threads = std::clamp(info.queues ? cores / 2 : cores / 4, 1U, 16U);
  options.host.slots = settings.slots;
  options.host.visitor_percent = settings.visitor_percent;
  options.host.mark_frames = settings.mark_frames;
  options.runner.rules.target_error = settings.max_error;
  options.policy = settings.policy;
  options.still_samples = settings.still_samples;
  options.runner.device_lost = leave_broken_device;
  return options;
}

GrpcServer::Options server_options(const Settings& settings) {
  GrpcServer::Options options;
  options.address = settings.grpc_address;
  options.port = settings.grpc_port;
  options.tls = settings.tls;
  // A gateway has one connection for all its sessions on this worker, and also requests thumbnails
  // over it.
  options.most_streams = std::max(options.most_streams, static_cast<int>(settings.slots) + 64);
  return options;
}

// A worker that is complete but not yet registered.
struct Parts {
  const Settings& settings;
  const EngineInfo& info;
  directory::Client& redis;
  GrpcAssistants* assistants;  // may be null
  service::AdminServer& admin;
  Metrics& metrics;
  const std::uint64_t volume_bytes;  // limit for loaded volumes
  RenderWorker& worker;
  GrpcServer& server;
  Observed& observed;
};

Registry::Options registry_options(const Parts& parts, const std::string& incarnation,
                                   std::atomic<bool>& name_taken) {
  const Settings& settings = parts.settings;
  RenderWorker& worker = parts.worker;
  return {.worker_id = settings.worker_id,
          .incarnation = incarnation,
          .address = settings.advertise,
          .engine = parts.info.engine,
          .device = parts.info.device,
          .node = settings.node,
          .busy_seconds = [&] { return worker.homes().busy_seconds(); },
          .volumes = [&] { return worker.volumes().loaded(); },
          .name_taken =
              [&](const std::string& holder) {
                std::fprintf(stderr,
                             "--worker-id: another renderd with this name is running at %s\n",
                             holder.c_str());
                name_taken = true;
              },
          .owner = settings.owner,
          .memory =
              [&worker, most = std::max<std::uint64_t>(1, parts.volume_bytes)] {
                return static_cast<double>(worker.volumes().bytes()) / static_cast<double>(most);
              },
          .error = [&] { return worker.homes().summed_error(); },
          // Moves a few sessions per second, so that they do not all arrive at other workers at
          // once.
          .drain_ordered =
              [&](std::size_t room) { worker.host().move_away(std::min<std::size_t>(room, 4)); },
          .lent_seconds = [&] { return worker.assists().lent_seconds(); }};
}

CapacityBroker::Options broker_options(const Parts& parts, const std::string& incarnation) {
  RenderWorker& worker = parts.worker;
  Metrics& metrics = parts.metrics;
  CapacityBroker::Options lending;
  lending.worker_id = parts.settings.worker_id;
  lending.incarnation = incarnation;
  lending.address = parts.settings.advertise;
  lending.node = parts.settings.node;
  lending.owner = parts.settings.owner;
  lending.rules.most = parts.settings.lend;
  lending.rules.most_spare = parts.settings.lend_spare ? parts.settings.lend : 0;
  lending.busy_seconds = [&] { return worker.homes().busy_seconds(); };
  lending.lent_seconds = [&] { return worker.assists().lent_seconds(); };
  lending.waiting = [&] { return worker.homes().waiting(); };
  lending.volumes = [&] { return worker.volumes().loaded(); };
  lending.updated = [&](std::size_t borrowed) {
    metrics.lending(borrowed, worker.assists().used());
  };
  return lending;
}

// A worker in service, from its registration until its sessions are handed over.
class ServingWorker {
 public:
  explicit ServingWorker(const Parts& parts) : parts_(parts) { start_watchdog(); }

  void run(service::StopSignal& stop);
  void drain();
  bool name_taken() const { return name_taken_; }

 private:
  void start_watchdog();

  const Parts parts_;
  // Progress of the main loop, which stops if a session's lock is never released.
  std::atomic<std::uint64_t> turns_{1};
  std::atomic<bool> name_taken_{false};
  const std::string incarnation_ = new_id();
  Registry registry_{registry_options(parts_, incarnation_, name_taken_), parts_.redis,
                     parts_.worker.host(), parts_.metrics};
  std::optional<CapacityBroker> broker_{std::in_place, broker_options(parts_, incarnation_),
                                        parts_.redis,
                                        parts_.settings.lend > 0 ? parts_.assistants : nullptr};
  std::optional<Watchdog> watchdog_;
};

void ServingWorker::start_watchdog() {
  if (parts_.settings.silence.count() == 0) return;
  std::vector<Watchdog::Watched> all;
  for (const ProgressMonitor* monitor : parts_.worker.homes().progress()) {
    for (Watchdog::Watched& one : watched(*monitor)) all.push_back(std::move(one));
  }
  all.push_back({"main loop", [this] { return turns_.load(); }});
  watchdog_.emplace(std::move(all), Watchdog::Options{.limit = parts_.settings.silence,
                                                      .poll_interval = milliseconds(250),
                                                      .hung = leave_hung});
}

void ServingWorker::run(service::StopSignal& stop) {
  parts_.observed.watchdog = watchdog_ ? &*watchdog_ : nullptr;
  parts_.observed.worker = &parts_.worker;
  parts_.observed.registry = &registry_;
  log::info("serving", {{"engine", parts_.info.engine},
                        {"device", parts_.info.device},
                        {"address", parts_.settings.advertise},
                        {"slots", parts_.settings.slots}});
  while (!stop.wait_for(milliseconds(200)) && !name_taken_) {
    ++turns_;
    parts_.worker.host().tick();
    parts_.server.sweep();
    parts_.metrics.device(parts_.worker.homes().times());
  }
}

void ServingWorker::drain() {
  log::info("draining");
  parts_.observed.watchdog = nullptr;
  watchdog_.reset();  // the drain has its own limit
  end_within(milliseconds(3500));
  broker_.reset();
  parts_.admin.set_draining();
  parts_.server.set_not_serving();
  parts_.worker.host().refuse_new();
  // Saves the scenes first, because the worker that resumes a session needs them.
  registry_.drain(milliseconds(1000));
  parts_.observed.registry = nullptr;
  parts_.observed.worker = nullptr;
  parts_.worker.stop();
  parts_.server.stop(milliseconds(1000));
}

int failed(const char* option, const Error& why, int exit_code) {
  std::fprintf(stderr, "%s: %s\n", option, why.message.c_str());
  return exit_code;
}

int run(const Settings& settings, service::StopSignal& stop) {
  // One connection for the registry and one for the capacity broker, so that neither waits for the
  // other.
  auto redis = directory::Client::create({.address = settings.redis,
                                          .connections = 2,
                                          .connect_timeout = milliseconds(1000),
                                          .command_timeout = milliseconds(1000),
                                          .tls = settings.tls});
  if (!redis) return failed("--redis", redis.error(), kExitConfig);

  std::unique_ptr<GrpcAssistants> assistants;
  if (!settings.assist.empty() || settings.lend > 0) {
    assistants = std::make_unique<GrpcAssistants>(settings.assist, settings.tls, settings.lend);
  }
  auto engine = engine_of(settings, assistants.get());
  if (!engine) return failed("--engine", engine.error(), kExitConfig);
  const EngineInfo info = (*engine)->info();
  const SystemClock clock;

  Observed observed;
  auto admin = start_admin(settings, info, observed);
  if (!admin) return failed("--admin-port", admin.error(), kExitUnavailable);
  Metrics metrics((*admin)->registry());

  const RenderWorker::Options options = worker_options(settings, info);
  limit_texture_memory(settings.texture_bytes, settings.texture_bytes / 8 * 5);
  set_environment_directory(settings.volume_dir + "/" + volume::kEnvironments);
  RenderWorker worker(options, std::move(*engine), metrics, clock);
  auto server = GrpcServer::start(server_options(settings), worker.host(), worker.stills(), metrics,
                                  &worker.assists());
  if (!server) return failed("--grpc-port", server.error(), kExitUnavailable);

  bool name_taken = false;
  {
    ServingWorker serving({.settings = settings,
                           .info = info,
                           .redis = **redis,
                           .assistants = assistants.get(),
                           .admin = **admin,
                           .metrics = metrics,
                           .volume_bytes = options.volume_bytes,
                           .worker = worker,
                           .server = **server,
                           .observed = observed});
    serving.run(stop);
    serving.drain();
    name_taken = serving.name_taken();
  }
  log::info("stopped");
  return name_taken ? kExitConfig : 0;
}

}  // namespace
}  // namespace diaphane::render

int main(int argc, char** argv) {
  // Freed memory may hold voxels: of evicted volumes, and of slices and pictures that were sent.
  diaphane::service::overwrite_freed_memory();
  diaphane::service::forbid_core_files();
  diaphane::ConfigReader in(argc, argv);
  const auto settings = diaphane::render::read_settings(in);
  if (const auto done = in.finish("diaphane-renderd: renders the sessions of many viewers on one "
                                  "device, or on several together")) {
    return *done;
  }
  diaphane::log::start("renderd");
  diaphane::service::StopSignal stop;
  return diaphane::render::run(settings, stop);
}
