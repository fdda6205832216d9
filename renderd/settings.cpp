#include "renderd/settings.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <sstream>

#include "common/background.h"
#include "common/connect.h"
#include "common/wire/redis_address.h"
#include "renderd/scene/texture_store.h"

namespace diaphane::render {
namespace {

std::string host_name() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

void read_devices(ConfigReader& in, Settings& settings) {
  const std::string devices = in.text("devices",
                                      "CUDA device numbers, separated by commas, or 'all'. "
                                      "Sessions are spread over these GPUs, and "
                                      "idle ones help the others. With the CPU engine, as many "
                                      "engines as numbers share the threads",
                                      "all");
  for (const std::string& word : devices == "all" ? std::vector<std::string>{} : split(devices)) {
    int number = 0;
    const auto [end, wrong] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (wrong != std::errc() || end != word.data() + word.size() || number < 0 ||
        std::count(settings.devices.begin(), settings.devices.end(), number) > 0) {
      in.mistake("--devices must be a comma-separated list of different numbers, each 0 or more");
      return;
    }
    settings.devices.push_back(number);
  }
  if (devices.empty()) in.mistake("--devices: no device given");
  settings.assist = split(in.text("assist",
                                  "comma-separated addresses (host:port or unix:PATH) of other "
                                  "renderd processes that help to render each "
                                  "picture",
                                  ""));
  settings.lend = static_cast<std::size_t>(in.integer(
      "lend", "maximum number of peer workers to borrow when this GPU is overloaded (0 = off)", 0,
      8, 0));
  settings.lend_spare =
      in.integer("lend-spare", "1 = also borrow the spare time of idle peers for a session alone",
                 0, 1, 0) == 1;
  for (const std::string& address : settings.assist) {
    const auto parsed = wire::parse_redis_address(address);
    if (!parsed || parsed->with_tls) {
      in.mistake("--assist: '" + address + "' is not a valid host:port or unix:PATH");
    } else if (!settings.tls.on()) {
      wire::check_address(in, "assist", address, settings.tls);
    }
  }
}

std::uint64_t bytes_of_mib(std::int64_t mib) { return static_cast<std::uint64_t>(mib) << 20; }

void read_redis(ConfigReader& in, Settings& settings) {
  settings.worker_id = in.text("worker-id", "name of this worker, unique per Redis");
  settings.tls = wire::read_inner_tls(in, wire::Role::kRenderd);
  settings.redis = wire::read_redis(in, settings.tls);
}

void read_addresses(ConfigReader& in, Settings& settings) {
  settings.grpc_address =
      in.text("grpc-address",
              "address that the gRPC server listens on, without a port, or unix:PATH", "127.0.0.1");
  if (!settings.tls.on()) {
    wire::check_address(in, "grpc-address", settings.grpc_address, settings.tls);
  }
  if (const std::string path = unix_path(settings.grpc_address); path.empty()) {
    settings.grpc_port =
        in.port("grpc-port", "port of the gRPC server, which the gateway connects to");
  } else if (path.front() != '/' || path.size() > kMostUnixPath) {
    in.mistake("--grpc-address: unix:PATH must be an absolute path of at most " +
               std::to_string(kMostUnixPath) + " bytes");
  }
  settings.advertise = in.text(
      "advertise", "address at which the gateway reaches this worker: host:port or unix:PATH");
  settings.admin = service::read_admin_options(in, "renderd");
}

void read_engine(ConfigReader& in, Settings& settings) {
  const std::string engine =
      in.one_of("engine", "rendering engine", {"auto", "cpu", "cuda"}, "auto");
  settings.engine = engine == "cpu"    ? EngineChoice::kCpu
                    : engine == "cuda" ? EngineChoice::kCuda
                                       : EngineChoice::kAuto;
  settings.threads = static_cast<unsigned>(in.integer(
      "threads",
      "threads of the CPU engine (0 = one per core); background work also uses at most this many "
      "cores",
      0, 1024, 0));
  background::limit_cores(settings.threads);
}

void read_max_error(ConfigReader& in, Settings& settings) {
  const std::string error =
      in.text("max-error", "relative error at which a picture counts as converged, between 0 and 1",
              "0.01");
  char* end = nullptr;
  settings.max_error = std::strtod(error.c_str(), &end);
  if (end == error.c_str() || *end != '\0' || !(settings.max_error > 0 && settings.max_error < 1)) {
    in.mistake("--max-error must be a number between 0 and 1");
  }
}

void read_scheduling(ConfigReader& in, Settings& settings) {
  settings.slots =
      static_cast<std::size_t>(in.integer("slots", "maximum number of sessions", 1, 4096, 8));
  settings.visitor_percent = static_cast<int>(in.integer(
      "visitor-share",
      "maximum percentage of the slots, and of the device's time, that people without an account "
      "may use together",
      0, 100, kVisitorPercent));
  read_max_error(in, settings);
  settings.still_samples = static_cast<std::uint32_t>(
      in.integer("still-samples",
                 "maximum samples per pixel of a picture without a session, such as a thumbnail", 1,
                 StillService::kMostSamples, StillService::kMostSamples));
  const std::string policy = in.one_of(
      "schedule", "scheduling policy, which chooses the session to render next",
      {"marginal-gain", "error-proportional", "round-robin", "free-for-all"}, "marginal-gain");
  settings.policy = policy_kind(policy).value_or(PolicyKind::kMarginalGain);
}

void read_memory(ConfigReader& in, Settings& settings) {
  settings.texture_bytes = bytes_of_mib(in.integer(
      "texture-memory-mb", "memory for the decoded light textures of all sessions, in MiB", 64,
      1 << 20, kTextureMemory >> 20));
  settings.options.film_bytes = bytes_of_mib(
      in.integer("film-memory-mb",
                 "CPU engine: memory for the pictures of all sessions, in MiB (0 = a quarter of "
                 "the memory of the machine or the container)",
                 0, 1 << 22, 0));
  settings.volume_bytes = bytes_of_mib(in.integer(
      "volume-memory-mb", "memory for loaded volumes, in MiB (0 = half of the device's memory)", 0,
      1 << 22, 0));
  settings.copies_dir =
      in.text("volume-copies-dir",
              "directory on the node's disk for copies of volumes (empty = no copies)", "");
  settings.copies_bytes = bytes_of_mib(
      in.integer("volume-copies-mb", "maximum size of all copies in that directory, in MiB", 1,
                 1 << 26, 20480));
}

void read_kernels(ConfigReader& in, Settings& settings) {
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
                "1 uses at most 5% more device memory than the voxels of a volume need", {"0", "1"},
                "0") == "1";
}

}  // namespace

Settings read_settings(ConfigReader& in) {
  Settings settings;
  read_redis(in, settings);
  read_addresses(in, settings);
  settings.volume_dir = in.directory("volume-dir", "directory of the volume store");
  read_engine(in, settings);
  read_scheduling(in, settings);
  read_memory(in, settings);
  settings.silence = std::chrono::seconds(in.integer(
      "watchdog-s",
      "time after which a hung device or main loop ends the process, in seconds (0 = never)", 0,
      3600, 15));
  read_kernels(in, settings);
  settings.mark_frames =
      in.one_of("mark-frames", "1 draws the number of the input into each picture, for benchmarks",
                {"0", "1"}, "0") == "1";
  settings.owner =
      in.text("owner", "owner of this worker, set by the operator that created its pod", "");
  settings.node = in.text(
      "node",
      "name of the machine, whose other workers are preferred as helpers (default: host name)",
      host_name());
  read_devices(in, settings);
  return settings;
}

}  // namespace diaphane::render
