// Entry point of renderd: reads settings, connects the parts and handles signals.

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

#include "common/background.h"
#include "common/clock.h"
#include "common/config.h"
#include "common/connect.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/service/admin_server.h"
#include "common/service/core_files.h"
#include "common/service/freed_memory.h"
#include "common/service/signals.h"
#include "common/wire/inner_tls.h"
#include "common/wire/redis_address.h"
#include "directory/client.h"
#include "renderd/composite/composite_engine.h"
#include "renderd/scene/texture_store.h"
#include "renderd/serve/capacity_broker.h"
#include "renderd/serve/grpc_assistants.h"
#include "renderd/serve/grpc_server.h"
#include "renderd/serve/registry.h"
#include "renderd/serve/render_worker.h"
#include "renderd/serve/watchdog.h"
#include "volume/node_cache.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;

constexpr int kExitUnavailable = 69;  // sysexits.h: EX_UNAVAILABLE
constexpr int kExitDevice = 70;       // EX_SOFTWARE: the device's context is broken

struct Settings {
  std::string worker_id;
  std::string redis;
  std::string grpc_address;
  std::uint16_t grpc_port = 0;
  std::string advertise;
  std::uint16_t admin_port = 0;
  std::string admin_address;
  std::string volume_dir;
  EngineChoice engine = EngineChoice::kAuto;
  unsigned threads = 0;
  std::size_t slots = 0;
  int visitor_percent = kVisitorPercent;
  double max_error = 0;
  std::uint32_t still_samples = StillService::kMostSamples;
  std::uint64_t volume_bytes = 0;
  std::uint64_t texture_bytes = 0;
  std::string copies_dir;
  std::uint64_t copies_bytes = 0;
  PolicyKind policy = PolicyKind::kMarginalGain;
  /// Watchdog limit for the device and the main loop; 0: no watchdog.
  std::chrono::seconds silence{0};
  EngineOptions options;
  bool mark_frames = false;
  std::vector<int> devices;
  std::vector<std::string> assist;
  std::size_t lend = 0;
  std::string owner;
  wire::InnerTls tls;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

void read_devices(ConfigReader& in, Settings& settings) {
  const std::string devices = in.text(
      "devices",
      "comma-separated CUDA device numbers of the GPUs that render each picture together; with the "
      "CPU engine, that many engines share the threads",
      "0");
  for (const std::string& word : split(devices)) {
    int number = 0;
    const auto [end, wrong] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (wrong != std::errc() || end != word.data() + word.size() || number < 0 ||
        std::count(settings.devices.begin(), settings.devices.end(), number) > 0) {
      in.mistake("--devices must be a comma-separated list of different numbers, each 0 or more");
      return;
    }
    settings.devices.push_back(number);
  }
  if (settings.devices.empty()) in.mistake("--devices: no device given");
  settings.assist = split(in.text("assist",
                                  "comma-separated addresses (host:port or unix:PATH) of other "
                                  "renderd processes that help to render each "
                                  "picture",
                                  ""));
  settings.lend = static_cast<std::size_t>(in.integer(
      "lend", "maximum number of peer workers to borrow when this GPU is overloaded (0 = off)", 0,
      8, 0));
  for (const std::string& address : settings.assist) {
    const auto parsed = wire::parse_redis_address(address);
    if (!parsed || parsed->with_tls) {
      in.mistake("--assist: '" + address + "' is not a valid host:port or unix:PATH");
    } else if (!settings.tls.on()) {
      wire::check_address(in, "assist", address, settings.tls);
    }
  }
}

void log_fallback(const Error& reason) {
  log::warning("cuda_not_used", {{"code", to_string(reason.code)}, {"message", reason.message}});
}

/// Returns a single device as it is, and several devices or assistants as one composite.
Result<std::unique_ptr<Engine>> engine_of(const Settings& settings, AssistSource* source) {
  const auto count = static_cast<unsigned>(settings.devices.size());
  const unsigned cores =
      settings.threads > 0 ? settings.threads : std::thread::hardware_concurrency();
  std::vector<std::unique_ptr<Engine>> engines;
  for (const int device : settings.devices) {
    EngineOptions options = settings.options;
    options.device = device;
    auto engine =
        make_engine(settings.engine, count > 1 ? std::max(1U, cores / count) : settings.threads,
                    options, log_fallback);
    if (!engine) return engine;
    engines.push_back(std::move(*engine));
  }
  if (count == 1 && source == nullptr) return std::move(engines.front());
  return make_composite_engine(std::move(engines), source);
}

// Without copies, everything works, but more slowly.
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

Settings read_settings(ConfigReader& in) {
  Settings settings;
  settings.worker_id = in.text("worker-id", "name of this worker, unique per Redis");
  settings.redis = in.text("redis", "address: host:port, rediss://host:port (TLS) or unix:PATH");
  settings.tls = wire::read_inner_tls(in, wire::Role::kRenderd);
  if (const auto address = wire::parse_redis_address(settings.redis)) {
    wire::check_address(in, "redis", settings.redis, settings.tls);
  } else if (!settings.redis.empty()) {
    in.mistake("--redis " + address.error().message);
  }
  settings.grpc_address =
      in.text("grpc-address", "address to listen on, without a port, or unix:PATH", "127.0.0.1");
  if (!settings.tls.on()) {
    wire::check_address(in, "grpc-address", settings.grpc_address, settings.tls);
  }
  if (const std::string path = unix_path(settings.grpc_address); path.empty()) {
    settings.grpc_port = in.port("grpc-port", "gRPC port, for the gateway");
  } else if (path.front() != '/' || path.size() > kMostUnixPath) {
    in.mistake("--grpc-address: unix:PATH must be an absolute path of at most " +
               std::to_string(kMostUnixPath) + " bytes");
  }
  settings.advertise =
      in.text("advertise", "host:port or unix:PATH at which the gateway reaches this worker");
  settings.admin_port = in.port("admin-port", "port for metrics and health checks");
  settings.admin_address =
      in.text("admin-address", "address on which the admin port listens", "127.0.0.1");
  settings.volume_dir = in.directory("volume-dir", "directory of the volume store");
  const std::string engine =
      in.one_of("engine", "rendering engine", {"auto", "cpu", "cuda"}, "auto");
  settings.engine = engine == "cpu"    ? EngineChoice::kCpu
                    : engine == "cuda" ? EngineChoice::kCuda
                                       : EngineChoice::kAuto;
  settings.threads = static_cast<unsigned>(in.integer(
      "threads",
      "threads of the CPU engine (0 = all cores). Background work also uses at most this many "
      "cores",
      0, 1024, 0));
  background::limit_cores(settings.threads);
  settings.slots =
      static_cast<std::size_t>(in.integer("slots", "maximum number of sessions", 1, 4096, 8));
  settings.visitor_percent = static_cast<int>(in.integer(
      "visitor-share",
      "percentage of the slots and of the device that users without an account may use together", 0,
      100, kVisitorPercent));
  const std::string error =
      in.text("max-error", "relative error at which a picture counts as converged, between 0 and 1",
              "0.01");
  char* end = nullptr;
  settings.max_error = std::strtod(error.c_str(), &end);
  if (end == error.c_str() || *end != '\0' || !(settings.max_error > 0 && settings.max_error < 1)) {
    in.mistake("--max-error must be a number between 0 and 1");
  }
  settings.still_samples = static_cast<std::uint32_t>(
      in.integer("still-samples",
                 "maximum samples per pixel of a picture without a session, such as a thumbnail", 1,
                 StillService::kMostSamples, StillService::kMostSamples));
  const std::string policy = in.one_of(
      "schedule", "scheduling policy, which decides which session is rendered next",
      {"marginal-gain", "error-proportional", "round-robin", "free-for-all"}, "marginal-gain");
  settings.policy = policy_kind(policy).value_or(PolicyKind::kMarginalGain);
  settings.texture_bytes =
      static_cast<std::uint64_t>(in.integer(
          "texture-memory-mb", "memory in MiB for decoded light textures of all sessions", 64,
          1 << 20, kTextureMemory >> 20))
      << 20;
  settings.options.film_bytes =
      static_cast<std::uint64_t>(
          in.integer("film-memory-mb",
                     "CPU engine: memory in MiB for the pictures of all sessions (0 = a quarter of "
                     "the memory that the machine or the container has)",
                     0, 1 << 22, 0))
      << 20;
  settings.volume_bytes =
      static_cast<std::uint64_t>(in.integer(
          "volume-memory-mb", "memory in MiB for loaded volumes (0 = half of the device's memory)",
          0, 1 << 22, 0))
      << 20;
  settings.copies_dir =
      in.text("volume-copies-dir",
              "directory on the node's disk for copies of volumes (empty = no copies)", "");
  settings.copies_bytes =
      static_cast<std::uint64_t>(in.integer("volume-copies-mb",
                                            "maximum size in MiB of all copies in that directory",
                                            1, 1 << 26, 20480))
      << 20;
  settings.silence = std::chrono::seconds(in.integer(
      "watchdog-s", "exit when the device or the main loop hangs for this many seconds (0 = never)",
      0, 3600, 15));
  const std::string kernels = in.one_of(
      "kernels",
      "CUDA engine: which kernels are compiled for a scene, and whether rendering waits for them",
      {"exact", "stand-in", "ahead-of-time", "general"}, "stand-in");
  settings.options.kernels = kernel_choice(kernels).value_or(KernelChoice::kStandIn);
  settings.options.kernel_cache =
      in.text("kernel-cache", "directory in which compiled kernels are cached (empty = no cache)",
              default_kernel_cache());
  settings.options.lean_memory =
      in.one_of("lean-memory",
                "1 = use at most 5% more device memory than the voxels of a volume need",
                {"0", "1"}, "0") == "1";
  settings.mark_frames =
      in.one_of("mark-frames",
                "1 = draw the number of the input into each picture (for benchmarks)", {"0", "1"},
                "0") == "1";
  settings.owner =
      in.text("owner", "owner of this worker, set by the operator that created its pod", "");
  read_devices(in, settings);
  return settings;
}

// This process can no longer use the device. The scenes of its sessions are already in Redis.
[[noreturn]] void leave_broken_device(const Error& why) {
  log::error("device_lost", {{"message", why.message}});
  std::_Exit(kExitDevice);
}

// Something hangs, so an orderly shutdown is impossible. Connections and heartbeats end with the
// process, and its supervisor restarts it. Its sessions are placed again with the scenes that are
// in Redis.
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

int run(int argc, char** argv) {
  ConfigReader in(argc, argv);
  const Settings settings = read_settings(in);
  if (const auto done = in.finish("diaphane-renderd: renders the sessions of many viewers on one "
                                  "device, or on several together")) {
    return *done;
  }
  log::start("renderd");
  service::StopSignal stop;

  // One connection for the registry and one for the capacity broker, so that neither waits for the
  // other.
  auto redis = directory::Client::create({.address = settings.redis,
                                          .connections = 2,
                                          .connect_timeout = milliseconds(1000),
                                          .command_timeout = milliseconds(1000),
                                          .tls = settings.tls});
  if (!redis) {
    std::fprintf(stderr, "--redis: %s\n", redis.error().message.c_str());
    return kExitConfig;
  }

  std::unique_ptr<GrpcAssistants> assistants;
  if (!settings.assist.empty() || settings.lend > 0) {
    assistants = std::make_unique<GrpcAssistants>(settings.assist, settings.tls, settings.lend);
  }
  auto engine = engine_of(settings, assistants.get());
  if (!engine) {
    std::fprintf(stderr, "--engine: %s\n", engine.error().message.c_str());
    return kExitConfig;
  }
  const EngineInfo info = (*engine)->info();
  const SystemClock clock;

  // Targets of the operations port, null before serving and during shutdown.
  std::atomic<RenderWorker*> worker_now{nullptr};
  std::atomic<Registry*> registry_now{nullptr};
  std::atomic<const Watchdog*> watchdog_now{nullptr};
  service::AdminServer::Options admin_options;
  admin_options.address = settings.admin_address;
  admin_options.port = settings.admin_port;
  admin_options.program = "renderd";
  admin_options.checks = {{"redis",
                           [&] {
                             const Registry* registry = registry_now;
                             return registry && registry->connected();
                           }},
                          {"signs of life",
                           [&] {
                             const Watchdog* watchdog = watchdog_now;
                             return !watchdog || !watchdog->suspects();
                           }},
                          {"volume store", [dir = settings.volume_dir] {
                             return access(dir.c_str(), R_OK | X_OK) == 0;
                           }}};
  admin_options.details = [&] {
    RenderWorker* worker = worker_now;
    return nlohmann::json{{"engine", info.engine},
                          {"device", info.device},
                          {"slots", settings.slots},
                          {"used", worker ? worker->host().used() : 0}}
        .dump();
  };
  auto admin = service::AdminServer::start(std::move(admin_options));
  if (!admin) {
    std::fprintf(stderr, "--admin-port: %s\n", admin.error().message.c_str());
    return kExitUnavailable;
  }
  Metrics metrics((*admin)->registry());

  RenderWorker::Options worker_options;
  worker_options.volume_dir = settings.volume_dir;
  worker_options.copies = copies_of(settings);
  if (settings.volume_bytes > 0) {
    worker_options.volume_bytes = settings.volume_bytes;
  } else if (info.memory_bytes > 0) {
    worker_options.volume_bytes = info.memory_bytes / 2;
  }
  // A GPU leaves the processor to the encoders, while the CPU engine needs it itself.
  const unsigned cores = std::thread::hardware_concurrency();
  worker_options.encoder_threads = std::clamp(info.queues ? cores / 2 : cores / 4, 1U, 16U);
  limit_texture_memory(settings.texture_bytes, settings.texture_bytes / 8 * 5);
  worker_options.host.slots = settings.slots;
  worker_options.host.visitor_percent = settings.visitor_percent;
  worker_options.host.mark_frames = settings.mark_frames;
  worker_options.runner.rules.target_error = settings.max_error;
  worker_options.policy = settings.policy;
  worker_options.still_samples = settings.still_samples;
  worker_options.runner.device_lost = leave_broken_device;
  RenderWorker worker(worker_options, std::move(*engine), metrics, clock);

  GrpcServer::Options server_options;
  server_options.address = settings.grpc_address;
  server_options.port = settings.grpc_port;
  server_options.tls = settings.tls;
  // A gateway has one connection for all its sessions on this worker, and also requests thumbnails
  // over it.
  server_options.most_streams =
      std::max(server_options.most_streams, static_cast<int>(settings.slots) + 64);
  auto server =
      GrpcServer::start(server_options, worker.host(), worker.stills(), metrics, &worker.assists());
  if (!server) {
    std::fprintf(stderr, "--grpc-port: %s\n", server.error().message.c_str());
    return kExitUnavailable;
  }
  // Progress of the main loop, which stops if a session's lock is never released.
  std::atomic<std::uint64_t> turns{1};
  std::atomic<bool> name_taken{false};
  {
    const std::string incarnation = new_id();
    Registry registry(
        {settings.worker_id, incarnation, settings.advertise, info.engine, info.device,
         [&] { return worker.runner().busy_seconds(); }, [&] { return worker.volumes().loaded(); },
         [&](const std::string& holder) {
           std::fprintf(stderr, "--worker-id: another renderd with this name is running at %s\n",
                        holder.c_str());
           name_taken = true;
         },
         settings.owner,
         [&] {
           return static_cast<double>(worker.volumes().bytes()) /
                  static_cast<double>(std::max<std::uint64_t>(1, worker_options.volume_bytes));
         },
         [&] { return worker.runner().summed_error(); },
         // A few per second, so that they do not all arrive at other workers at once.
         [&](std::size_t room) { worker.host().move_away(std::min<std::size_t>(room, 4)); },
         [&] { return worker.assists().lent_seconds(); }},
        **redis, worker.host(), metrics);
    CapacityBroker::Options lending;
    lending.worker_id = settings.worker_id;
    lending.incarnation = incarnation;
    lending.address = settings.advertise;
    lending.owner = settings.owner;
    lending.rules.most = settings.lend;
    lending.busy_seconds = [&] { return worker.runner().busy_seconds(); };
    lending.lent_seconds = [&] { return worker.assists().lent_seconds(); };
    lending.waiting = [&] { return worker.runner().waiting(); };
    lending.volumes = [&] { return worker.volumes().loaded(); };
    lending.updated = [&](std::size_t borrowed) {
      metrics.lending(borrowed, worker.assists().used());
    };
    std::optional<CapacityBroker> broker(std::in_place, std::move(lending), **redis,
                                         settings.lend > 0 ? assistants.get() : nullptr);
    std::optional<Watchdog> watchdog;
    if (settings.silence.count() > 0) {
      std::vector<Watchdog::Watched> all = watched(worker.runner().progress());
      all.push_back({"main loop", [&] { return turns.load(); }});
      watchdog.emplace(std::move(all), Watchdog::Options{.limit = settings.silence,
                                                         .poll_interval = milliseconds(250),
                                                         .hung = leave_hung});
    }
    watchdog_now = watchdog ? &*watchdog : nullptr;
    worker_now = &worker;
    registry_now = &registry;
    log::info("serving", {{"engine", info.engine},
                          {"device", info.device},
                          {"address", settings.advertise},
                          {"slots", settings.slots}});
    while (!stop.wait_for(milliseconds(200)) && !name_taken) {
      ++turns;
      worker.host().tick();
      (*server)->sweep();
      metrics.device(worker.runner().times());
    }

    log::info("draining");
    watchdog_now = nullptr;
    watchdog.reset();  // the drain has its own limit
    end_within(milliseconds(3500));
    broker.reset();
    (*admin)->set_draining();
    (*server)->set_not_serving();
    worker.host().refuse_new();
    // The scenes first, because the worker that resumes a session needs them.
    registry.drain(milliseconds(1000));
    registry_now = nullptr;
    worker_now = nullptr;
    worker.stop();
    (*server)->stop(milliseconds(1000));
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
  return diaphane::render::run(argc, argv);
}
