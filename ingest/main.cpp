// diaphane-ingestd: wiring only.
#include <atomic>
#include <cstdio>
#include <thread>

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
#include "ingest/pipeline/builder.h"
#include "ingest/pipeline/checked_builder.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/cut_child.h"
#include "ingest/pipeline/postgres_jobs.h"
#include "ingest/pipeline/scratch.h"
#include "ingest/pipeline/worker.h"
#include "volume/store.h"

namespace {

using namespace diaphane;

constexpr int kExitUnavailable = 69;  // sysexits.h: EX_UNAVAILABLE

struct Options {
  std::string postgres;
  std::uint16_t admin_port = 0;
  std::string admin_address;
  std::chrono::milliseconds lease{5000};
  ingest::SandboxBuilder::Options builder;
  std::optional<ingest::CheckedBuilder::Options> antivirus;
  ingest::Worker::Options worker;
};

std::optional<ingest::CheckedBuilder::Options> read_antivirus(ConfigReader& in,
                                                              bool plain_allowed) {
  ingest::CheckedBuilder::Options options;
  options.clamd.address =
      in.text("antivirus", "clamd: path of its socket, or host:port; empty: none", "");
  options.pass_unchecked =
      in.one_of("antivirus-away", "what is done with uploads while clamd cannot be asked",
                {"refuse", "pass"}, "refuse") == "pass";
  options.clamd.silence = std::chrono::seconds(in.integer(
      "antivirus-silence-s", "clamd may be as long without an answer, seconds", 1, 3600, 30));
  options.clamd.most_bytes =
      static_cast<std::uint64_t>(
          in.integer("antivirus-stream-mb",
                     "longest stream for clamd, MiB; at most its StreamMaxLength", 1, 2048, 25))
      << 20;
  wire::InnerTls tls;
  tls.plain_allowed = plain_allowed;
  const std::string& address = options.clamd.address;
  if (address.empty()) return std::nullopt;
  if (!address.starts_with('/')) {
    if (address.find(':') == std::string::npos) {
      in.mistake("--antivirus: '" + address + "' is neither a path from / on nor host:port");
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
  options.worker.upload_dir = in.directory("upload-dir", "where uploads arrive, as <id>.tar");
  options.worker.volume_dir = in.directory("volume-dir", "the volume store");
  options.builder.scratch_dir = in.directory("scratch-dir", "for unnamed files while building");
  options.admin_port = in.port("admin-port", "metrics and health");
  options.admin_address = in.text("admin-address", "address of the admin port", "127.0.0.1");
  options.builder.memory_limit_mb = static_cast<std::uint64_t>(
      in.integer("memory-limit-mb", "address space of a child, MiB", 64, 1 << 20, 6144));
  options.builder.time_limit_s = static_cast<std::uint32_t>(
      in.integer("time-limit-s", "time of a child, seconds", 1, 86400, 300));
  options.builder.quota_mb =
      static_cast<std::uint64_t>(in.integer("quota-mb", "the largest volume, MiB", 1, 8192, 2048));
  options.lease = std::chrono::milliseconds(
      in.integer("lease-ms", "how long a job is held between renewals", 500, 600000, 5000));
  options.worker.renew = options.lease * 3 / 10;
  options.antivirus = read_antivirus(in, plain_allowed);
  options.builder.program = "/proc/self/exe";
  return in.finish("diaphane-ingestd: makes volumes of uploaded series");
}

void sweep(const Options& options) {
  const auto volumes = volume::sweep_unfinished(options.worker.volume_dir);
  const auto scratch = ingest::sweep_scratch(options.builder.scratch_dir);
  log::info("swept", {{"volumes", volumes.value_or(0)}, {"scratch", scratch}});
}

int serve(const Options& options) {
  service::StopSignal stop;
  std::atomic<bool> postgres_there{false};
  service::AdminServer::Options admin_options;
  admin_options.address = options.admin_address;
  admin_options.port = options.admin_port;
  admin_options.program = "ingestd";
  admin_options.checks = {
      {"postgres", [&] { return postgres_there.load(); }},
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
  events.postgres = [&](bool there) { postgres_there = there; };
  ingest::PostgresJobs jobs(options.postgres, new_id(), options.lease);
  ingest::SandboxBuilder builder(options.builder);
  std::optional<ingest::CheckedBuilder> checked;
  if (options.antivirus) checked.emplace(*options.antivirus, builder, metrics.antivirus());
  ingest::Builder& first = checked ? static_cast<ingest::Builder&>(*checked) : builder;
  ingest::Worker worker(options.worker, jobs, first, std::move(events));
  // Children end with the thread that made them (supervisor.cpp): it lives as long as the work
  // does.
  std::thread thread([&] { worker.run(); });
  log::info("started");
  const int signal = stop.wait();
  log::info("draining", {{"signal", signal}});
  (*admin)->set_draining();
  worker.stop();
  thread.join();
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
  if (argc > 1 && std::string(argv[1]) == ingest::kCutChildWord) {
    return ingest::run_cut_child_with({argv + 2, argv + argc});
  }
  Options options;
  if (auto done = read_options(argc, argv, options)) return *done;
  log::start("ingestd");
  return serve(options);
}
