#include "api/load/stage.h"

#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "common/ids.h"
#include "common/try.h"
#include "directory/client.h"
#include "directory/sessions.h"

namespace diaphane::api::load {
namespace {

namespace fs = std::filesystem;

std::string end_of(const std::string& path) {
  std::ifstream file(path);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  return text.size() > 2000 ? text.substr(text.size() - 2000) : text;
}

}  // namespace

Result<std::unique_ptr<Stage>> Stage::set(Options options) {
  std::unique_ptr<Stage> stage(new Stage);
  char pattern[] = "/tmp/diaphane-load-XXXXXX";
  if (::mkdtemp(pattern) == nullptr)
    return fail(ErrorCode::kUnavailable, "cannot create a temporary directory");
  stage->folder_ = pattern;
  stage->log_dir_ = options.log_dir.empty() ? stage->folder_ : options.log_dir;
  DIAPHANE_TRY(stage->start_all(options));
  return stage;
}

Result<void> Stage::start_all(const Options& options) {
  std::error_code wrong;
  volume_id_ = new_id();
  const std::string store = folder_ + "/volumes";
  fs::create_directories(store, wrong);
  fs::create_directories(log_dir_, wrong);
  fs::copy(options.volume_dir, store + "/" + volume_id_, wrong);
  if (wrong || !fs::exists(store + "/" + volume_id_ + "/volume.json")) {
    return fail(ErrorCode::kInvalid, options.volume_dir + " does not contain a volume");
  }
  for (std::uint16_t* port : {&stream_port_, &gateway_admin_, &renderd_admin_}) {
    auto claimed = ClaimedPort::take();
    DIAPHANE_TRY(claimed);
    *port = claimed->number();
    ports_.push_back(*std::move(claimed));
  }
  origin_ = "http://localhost:" + std::to_string(stream_port_);

  const auto log = [&](const char* name) { return log_dir_ + "/" + name + ".log"; };
  const auto add = [&](const std::string& program, const std::vector<std::string>& arguments,
                       const char* name) -> Result<void> {
    auto child = Child::start(program, arguments, {}, log(name));
    DIAPHANE_TRY(child);
    children_.push_back(std::move(*child));
    return {};
  };
  const auto until = std::chrono::steady_clock::now() + options.start;
  const auto wait = [&](const std::function<bool()>& done, const char* name) -> Result<void> {
    while (!done()) {
      if (!children_.back().running() || std::chrono::steady_clock::now() > until) {
        return fail(ErrorCode::kUnavailable,
                    std::string(name) + " did not start:\n" + end_of(log(name)));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return {};
  };

  const std::string own_redis = options.bin_dir + "/redis-server";
  const std::string redis_program =
      ::access(own_redis.c_str(), X_OK) == 0 ? own_redis : "redis-server";
  auto client = directory::Client::create({.address = redis()});
  DIAPHANE_TRY(client);
  directory::Sessions sessions(**client);
  auto done = add(redis_program,
                  {"--port", "0", "--unixsocket", folder_ + "/redis.sock", "--save", "",
                   "--appendonly", "no", "--dir", folder_},
                  "redis")
                  .and_then([&] { return wait([&] { return sessions.reachable(); }, "redis"); });
  if (!done) return done;

  const std::string socket = "unix:" + folder_ + "/renderd.sock";
  std::vector<std::string> renderd{"--worker-id=load",
                                   "--redis=" + redis(),
                                   "--grpc-address=" + socket,
                                   "--advertise=" + socket,
                                   "--admin-port=" + std::to_string(renderd_admin_),
                                   "--volume-dir=" + store,
                                   "--engine=" + options.engine,
                                   "--slots=" + std::to_string(options.slots)};
  renderd.insert(renderd.end(), options.renderd_options.begin(), options.renderd_options.end());
  done = add(options.bin_dir + "/diaphane-renderd", renderd, "renderd").and_then([&] {
    return wait([&] { return ready(renderd_admin_); }, "renderd");
  });
  if (!done) return done;

  return add(options.bin_dir + "/diaphane-gateway",
             {"--redis=" + redis(), "--stream-port=" + std::to_string(stream_port_),
              "--admin-port=" + std::to_string(gateway_admin_), "--public-url=" + origin_},
             "gateway")
      .and_then([&] { return wait([&] { return ready(gateway_admin_); }, "gateway"); });
}

Stage::~Stage() {
  while (!children_.empty()) {  // in the order gateway, renderd, Redis
    children_.back().stop(std::chrono::seconds(5));
    children_.pop_back();
  }
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

bool Stage::stands() {
  for (Child& child : children_) {
    if (!child.running()) return false;
  }
  return true;
}

Usage Stage::usage() const {
  Usage usage;
  usage.at = std::chrono::steady_clock::now();
  usage.redis = processor_seconds(children_.at(0).pid());
  usage.renderd = processor_seconds(children_.at(1).pid());
  usage.gateway = processor_seconds(children_.at(2).pid());
  usage.viewers = processor_seconds(::getpid());
  usage.worker = scrape(renderd_admin_);
  usage.streams = scrape(gateway_admin_);
  return usage;
}

}  // namespace diaphane::api::load
