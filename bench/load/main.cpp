// diaphane-load has two commands: `bench` starts programs and viewers and reports, and `soak` runs
// viewers against running programs.
#include <signal.h>
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/load/load_run.h"
#include "bench/load/soak_run.h"
#include "common/config.h"
#include "directory/client.h"
#include "directory/sessions.h"

namespace diaphane::api::load {
namespace {

constexpr int kExitUnavailable = 69;  // sysexits.h
constexpr char kAbout[] =
    "diaphane-load: simulates many viewers and measures their image streams\n"
    "\n"
    "Commands: bench starts a renderer and a gateway, soak uses running ones";

double decimal(ConfigReader& in, const char* name, const char* help, const char* fallback) {
  const std::string text = in.text(name, help, fallback);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !(value > 0)) {
    in.mistake("--" + std::string(name) + " must be a number above 0");
  }
  return value;
}

std::vector<v1::Codec> codecs(ConfigReader& in) {
  const std::string codec =
      in.one_of("codec", "codec that the viewers prefer", {"jpeg", "h264", "mpeg1"}, "jpeg");
  if (codec == "h264") return {v1::H264, v1::JPEG};
  if (codec == "mpeg1") return {v1::MPEG1, v1::JPEG};
  return {v1::JPEG};
}

/// Reads --recording, so that the viewers move as in it, in a window of its size.
void read_recording(ConfigReader& in, CrowdOptions& crowd) {
  const std::string path = in.text(
      "recording", "recorded interaction that the viewers play (empty = they turn the scan)", "");
  if (path.empty()) return;
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  auto recording = Recording::read(text);
  if (!recording) return in.mistake("--recording " + path + ": " + recording.error().message);
  crowd.viewer.width = recording->width;
  crowd.viewer.height = recording->height;
  crowd.recording = std::make_shared<const Recording>(*std::move(recording));
}

int write(const nlohmann::ordered_json& report, const std::string& file) {
  const std::string text = report.dump(1) + "\n";
  if (file.empty()) {
    std::cout << text;
    return 0;
  }
  std::ofstream out(file);
  if (out << text) return 0;
  std::fprintf(stderr, "cannot write %s\n", file.c_str());
  return kExitUnavailable;
}

int refuse(const Error& why) {
  std::fprintf(stderr, "%s\n", why.message.c_str());
  return why.code == ErrorCode::kInvalid ? kExitConfig : kExitUnavailable;
}

int bench(ConfigReader& in) {
  LoadOptions options;
  CrowdOptions& crowd = options.crowd;
  crowd.sessions =
      static_cast<std::size_t>(in.integer("sessions", "number of open sessions", 1, 4096, 200));
  const std::int64_t moving =
      in.integer("moving", "number of sessions that move at any time (0 = 16%)", 0, 4096, 0);
  crowd.moving = moving > 0 ? static_cast<std::size_t>(moving)
                            : std::max<std::size_t>(1, (crowd.sessions * 32 + 100) / 200);
  crowd.seconds = decimal(in, "seconds", "seconds to measure", "10");
  crowd.warm_up_seconds = decimal(in, "warm-up", "seconds of movement before measuring", "4");
  crowd.opening_seconds =
      decimal(in, "opening", "maximum seconds until every session shows a picture", "120");
  crowd.preset = in.text("preset", "preset to view (empty = the default of the scan)", "bone");
  crowd.threads = static_cast<unsigned>(
      in.integer("viewer-threads", "threads of all viewers together", 1, 64, 2));
  crowd.seed =
      static_cast<std::uint64_t>(in.integer("seed", "seed of the random numbers", 0, 1 << 30, 1));
  crowd.viewer.codecs = codecs(in);
  read_recording(in, crowd);
  const std::string size =
      in.text("size", "window size in pixels, WxH (empty = of the recording, or 1280x720)", "");
  if (!size.empty() &&
      std::sscanf(size.c_str(), "%ux%u", &crowd.viewer.width, &crowd.viewer.height) != 2) {
    in.mistake("--size must be WIDTHxHEIGHT");
  }
  options.stage.bin_dir =
      in.directory("bin-dir", "directory of diaphane-renderd and diaphane-gateway");
  options.stage.volume_dir = in.directory("volume", "directory of a volume in the volume store");
  options.stage.engine = in.one_of("engine", "rendering engine", {"auto", "cpu", "cuda"}, "auto");
  options.stage.log_dir =
      in.text("log-dir", "directory for the logs of the programs (empty = do not keep them)", "");
  options.bound_seconds = 1e-3 * decimal(in, "bound-ms", "limit for the p95 latency, in ms", "100");
  options.repeats = static_cast<unsigned>(in.integer("repeats", "number of runs", 1, 100, 1));
  options.most_sessions = static_cast<std::size_t>(
      in.integer("most", "maximum number of sessions for --find", 1, 4096, 1024));
  options.find = in.flag("find", "also find the largest number of sessions within the limit");
  const std::string file =
      in.text("json", "write the report to this file; empty: standard output", "");
  if (auto done = in.finish(kAbout)) return *done;
  const auto report = load_run(
      options, [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
  if (!report) return refuse(report.error());
  return write(*report, file);
}

int soak(ConfigReader& in) {
  SoakOptions options;
  const std::string redis = in.text("redis", "Redis address: host:port");
  options.viewer.port = in.port("stream-port", "port of the gateway on this machine");
  options.viewer.origin =
      in.text("public-url", "origin that browsers use, such as https://host[:port]");
  options.viewer.codecs = codecs(in);
  options.data_set = in.text("data-set", "ID of a volume in the volume store");
  options.people = static_cast<std::size_t>(
      in.integer("people", "number of people at the same time", 1, 4096, 50));
  options.seconds = decimal(in, "seconds", "duration in seconds", "60");
  options.act_seconds = decimal(in, "act-seconds", "approximate seconds per pause or drag", "4");
  options.scale = decimal(in, "scale", "scale of the window sizes", "1");
  options.seed =
      static_cast<std::uint64_t>(in.integer("seed", "seed of the random numbers", 0, 1 << 30, 1));
  const std::string file =
      in.text("json", "write the report to this file; empty: standard output", "");
  if (auto done = in.finish(kAbout)) return *done;
  auto client = directory::Client::create({.address = redis});
  if (!client) return refuse(client.error());
  directory::Sessions placement(**client);
  return write(soak_run(options, placement), file);
}

// Raises the limit of open files: a session needs more than two, and 1024 are usually allowed.
void raise_descriptors() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  (void)::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace
}  // namespace diaphane::api::load

int main(int argc, char** argv) {
  using namespace diaphane;
  ::signal(SIGPIPE, SIG_IGN);
  api::load::raise_descriptors();
  ConfigReader in(argc, argv);
  const std::string word = in.words().empty() ? "" : in.words().front();
  if (word == "bench") return api::load::bench(in);
  if (word == "soak") return api::load::soak(in);
  in.mistake("missing command: bench or soak");
  return in.finish(api::load::kAbout).value_or(kExitUsage);
}
