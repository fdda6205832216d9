// The main program of diaphane-ingestd, which only creates and connects its parts.
#include <atomic>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "common/config.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/postgres/address.h"
#include "common/service/admin_server.h"
#include "common/service/core_files.h"
#include "common/service/freed_memory.h"
#include "common/service/signals.h"
#include "common/wire/inner_tls.h"
#include "ingest/metrics.h"
#include "ingest/pipeline/align_child.h"
#include "ingest/pipeline/align_work.h"
#include "ingest/pipeline/builder.h"
#include "ingest/pipeline/checked_builder.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/cut_child.h"
#include "ingest/pipeline/export_child.h"
#include "ingest/pipeline/export_work.h"
#include "ingest/pipeline/label_child.h"
#include "ingest/pipeline/postgres_jobs.h"
#include "ingest/pipeline/scratch.h"
#include "ingest/pipeline/worker.h"
#include "volume/store.h"

namespace {

using namespace diaphane;

constexpr int kExitUnavailable = 69;  // sysexits.h: EX_UNAVAILABLE

struct Options {
  std::string postgres;
  service::AdminServer::Options admin;
  std::string process = new_id();  ///< identifies this process in leases
  std::chrono::milliseconds lease{5000};
  std::uint64_t light_mb = 0;
  ingest::SandboxBuilder::Options builder;
  std::optional<ingest::CheckedBuilder::Options> antivirus;
  ingest::Worker::Options worker;
  ingest::ExportWorker::Options exports;
};

std::optional<ingest::CheckedBuilder::Options> read_antivirus(ConfigReader& in,
                                                              bool plain_allowed) {
  ingest::CheckedBuilder::Options options;
  options.clamd.address =
      in.text("antivirus", "clamd address: socket path or host:port (empty = no virus scan)", "");
  options.pass_unchecked =
      in.one_of("antivirus-away",
                "whether uploads wait or pass unchecked while clamd is unavailable",
                {"wait", "pass"}, "wait") == "pass";
  options.clamd.silence = std::chrono::seconds(in.integer(
      "antivirus-silence-s", "time to wait for a response from clamd, in seconds", 1, 3600, 30));
  options.clamd.most_bytes =
      static_cast<std::uint64_t>(
          in.integer("antivirus-stream-mb",
                     "maximum stream size for clamd, in MiB; must not exceed its StreamMaxLength",
                     1, 2048, 25))
      << 20;
  wire::InnerTls tls;
  tls.plain_allowed = plain_allowed;
  const std::string& address = options.clamd.address;
  if (address.empty()) return std::nullopt;
  if (!address.starts_with('/')) {
    if (address.find(':') == std::string::npos) {
      in.mistake("--antivirus: '" + address + "' is neither an absolute path nor host:port");
    } else {
      wire::check_address(in, "antivirus", address, tls);
    }
  }
  return options;
}

std::optional<int> read_options(int argc, char** argv, Options& options) {
  ConfigReader in(argc, argv);
  const bool plain_allowed = wire::read_plain_allowed(in);
  options.postgres = postgres::read_url(in, plain_allowed);
  options.worker.upload_dir = in.directory("upload-dir", "directory of uploads, named <id>.tar");
  options.worker.volume_dir = in.directory("volume-dir", "directory of the volume store");
  options.builder.scratch_dir =
      in.directory("scratch-dir", "directory for temporary files while a volume is built");
  options.exports.export_dir = in.text(
      "export-dir", "directory of exported scans, which api serves (empty = make no exports)", "");
  options.exports.volume_dir = options.worker.volume_dir;
  options.admin = service::read_admin_options(in, "ingestd");
  options.builder.memory_limit_mb = static_cast<std::uint64_t>(in.integer(
      "memory-limit-mb", "address space limit per child process, in MiB", 64, 1 << 20, 6144));
  options.builder.time_limit_s = static_cast<std::uint32_t>(
      in.integer("time-limit-s", "time limit per child process, in seconds", 1, 86400, 300));
  options.builder.quota_mb = static_cast<std::uint64_t>(
      in.integer("quota-mb", "maximum size of a volume, in MiB", 1, 8192, 2048));
  options.builder.reserve_mb = static_cast<std::uint64_t>(in.integer(
      "disk-reserve-mb", "disk space to keep free for volumes and temporary files, in MiB", 0,
      1'000'000, 256));
  options.light_mb = static_cast<std::uint64_t>(in.integer(
      "light-mb",
      "a second worker handles uploads and volumes up to this size, in MiB (0 = no second worker)",
      0, 8192, 256));
  options.lease = std::chrono::milliseconds(
      in.integer("lease-ms", "lease time of a job between renewals, in ms", 500, 600000, 5000));
  options.worker.renew = options.lease * 3 / 10;
  options.worker.poll = std::chrono::milliseconds(in.integer(
      "poll-ms", "how often to look for jobs that are due again; new ones are announced, in ms", 10,
      3'600'000, 1000));
  options.exports.renew = options.worker.renew;
  options.antivirus = read_antivirus(in, plain_allowed);
  options.builder.program = "/proc/self/exe";
  options.builder.volume_dir = options.worker.volume_dir;
  return in.finish("diaphane-ingestd: builds volumes from uploaded DICOM series");
}

void sweep(const Options& options) {
  const auto volumes = volume::sweep_unfinished(options.worker.volume_dir);
  const auto scratch = ingest::sweep_scratch(options.builder.scratch_dir);
  log::info("swept", {{"volumes", volumes.value_or(0)}, {"scratch", scratch}});
}

/// One worker with its dependencies, in its own thread. Children end with the thread that started
/// them (supervisor.cpp), so the thread lives as long as the work does.
class Lane {
 public:
  /// If `light_mb` is above 0, the worker takes only jobs up to that size.
  Lane(const Options& options, std::uint64_t light_mb,
       const std::function<void(const std::string&)>& malware, const ingest::WorkerEvents& events)
      : jobs_({.url = options.postgres,
               .claimer = options.process + (light_mb > 0 ? " light" : " all"),
               .process = options.process,
               .lease = options.lease,
               .light_bytes = light_mb << 20}),
        sandbox_(with_light(options.builder, light_mb)) {
    if (options.antivirus) checked_.emplace(*options.antivirus, sandbox_, malware);
    ingest::Builder& first = checked_ ? static_cast<ingest::Builder&>(*checked_) : sandbox_;
    worker_.emplace(options.worker, jobs_, first, events);
    // Only the worker for jobs of any size makes exports and alignments, because they may need much
    // memory or time.
    if (light_mb == 0) {
      if (!options.exports.export_dir.empty()) make_exports(options);
      make_alignments(options);
      worker_->alternate_with([this] { return work_on_stored_scans(); });
    }
    thread_ = std::thread([this] { worker_->run(); });
  }
  ~Lane() {
    stop();
    thread_.join();
  }
  Lane(const Lane&) = delete;
  Lane& operator=(const Lane&) = delete;
  void stop() { worker_->stop(); }

 private:
  void make_exports(const Options& options) {
    export_jobs_.emplace(ingest::LeaseOptions{
        .url = options.postgres, .claimer = options.process, .lease = options.lease});
    exports_.emplace(options.exports, *export_jobs_,
                     [this](const ingest::ExportInput& input,
                            const ingest::Builder::ShouldContinue& should_continue) {
                       return sandbox_.export_scan(input, should_continue);
                     });
  }
  void make_alignments(const Options& options) {
    align_jobs_.emplace(ingest::LeaseOptions{
        .url = options.postgres, .claimer = options.process, .lease = options.lease});
    alignments_.emplace(ingest::AlignWorker::Options{.volume_dir = options.worker.volume_dir,
                                                     .renew = options.exports.renew},
                        *align_jobs_,
                        [this](const ingest::AlignInput& input,
                               const ingest::Builder::ShouldContinue& should_continue) {
                          return sandbox_.align(input, should_continue);
                        });
  }
  /// Makes an export and an alignment if there are some. Returns whether there was any.
  bool work_on_stored_scans() {
    const auto is_stopping = [this] { return worker_->is_stopping(); };
    const bool exported = exports_ && exports_->work_once(is_stopping);
    return alignments_->work_once(is_stopping) || exported;
  }
  static ingest::SandboxBuilder::Options with_light(ingest::SandboxBuilder::Options options,
                                                    std::uint64_t light_mb) {
    options.light_mb = light_mb;
    return options;
  }
  ingest::PostgresJobs jobs_;
  ingest::SandboxBuilder sandbox_;
  std::optional<ingest::CheckedBuilder> checked_;
  std::optional<ingest::PostgresExports> export_jobs_;
  std::optional<ingest::ExportWorker> exports_;
  std::optional<ingest::PostgresAlignments> align_jobs_;
  std::optional<ingest::AlignWorker> alignments_;
  std::optional<ingest::Worker> worker_;
  std::thread thread_;
};

int serve(const Options& options) {
  service::StopSignal stop;
  std::atomic<bool> postgres_available{false};
  service::AdminServer::Options admin_options = options.admin;
  admin_options.checks = {
      {"postgres", [&] { return postgres_available.load(); }},
      {"volume store", [&] { return ingest::can_write(options.worker.volume_dir); }},
      {"scratch", [&] { return ingest::can_write(options.builder.scratch_dir); }}};
  auto admin = service::AdminServer::start(std::move(admin_options));
  if (!admin) {
    std::fprintf(stderr, "diaphane-ingestd: %s\n", admin.error().message.c_str());
    return kExitUnavailable;
  }
  sweep(options);
  ingest::Metrics metrics((*admin)->registry());
  ingest::WorkerEvents events = metrics.events();
  events.postgres = [&](bool available) { postgres_available = available; };
  const auto malware = options.antivirus ? metrics.antivirus() : nullptr;
  std::vector<std::unique_ptr<Lane>> lanes;
  lanes.push_back(std::make_unique<Lane>(options, 0, malware, events));
  if (options.light_mb > 0) {
    lanes.push_back(std::make_unique<Lane>(options, options.light_mb, malware, events));
  }
  log::info("started");
  const int signal = stop.wait();
  log::info("draining", {{"signal", signal}});
  (*admin)->set_draining();
  for (const auto& lane : lanes) lane->stop();
  lanes.clear();
  log::info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  service::overwrite_freed_memory();
  service::forbid_core_files();
  if (argc > 1 && std::string(argv[1]) == ingest::kChildWord) {
    return ingest::run_child_with({argv + 2, argv + argc});
  }
  if (argc > 1 && std::string(argv[1]) == ingest::kLabelChildWord) {
    return ingest::run_label_child_with({argv + 2, argv + argc});
  }
  if (argc > 1 && std::string(argv[1]) == ingest::kExportChildWord) {
    return ingest::run_export_child_with({argv + 2, argv + argc});
  }
  if (argc > 1 && std::string(argv[1]) == ingest::kAlignChildWord) {
    return ingest::run_align_child_with({argv + 2, argv + argc});
  }
  if (argc > 1 && std::string(argv[1]) == ingest::kCutChildWord) {
    return ingest::run_cut_child_with({argv + 2, argv + argc});
  }
  Options options;
  if (auto done = read_options(argc, argv, options)) return *done;
  log::start("ingestd");
  return serve(options);
}
