#include "bench/load/stage.h"

#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
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
  DIAPHANE_TRY(copy_volume(options.volume_dir));
  DIAPHANE_TRY(claim_ports());
  start_by_ = std::chrono::steady_clock::now() + options.start;
  DIAPHANE_TRY(start_redis(options));
  DIAPHANE_TRY(start_renderd(options));
  return start_gateway(options);
}

Result<void> Stage::copy_volume(const std::string& volume_dir) {
  std::error_code wrong;
  volume_id_ = new_id();
  const std::string copy = store() + "/" + volume_id_;
  fs::create_directories(store(), wrong);
  fs::create_directories(log_dir_, wrong);
  fs::copy(volume_dir, copy, wrong);
  if (wrong || !fs::exists(copy + "/volume.json")) {
    return fail(ErrorCode::kInvalid, volume_dir + " does not contain a volume");
  }
  return {};
}

Result<void> Stage::claim_ports() {
  for (std::uint16_t* port : {&stream_port_, &gateway_admin_, &renderd_admin_}) {
    auto claimed = ClaimedPort::take();
    DIAPHANE_TRY(claimed);
    *port = claimed->number();
    ports_.push_back(*std::move(claimed));
  }
  origin_ = "http://localhost:" + std::to_string(stream_port_);
  return {};
}

Result<void> Stage::start(const char* name, const std::string& program,
                          const std::vector<std::string>& arguments,
                          const std::function<bool()>& is_ready) {
  const std::string log = log_dir_ + "/" + name + ".log";
  auto child = Child::start(program, arguments, {}, log);
  DIAPHANE_TRY(child);
  children_.push_back(std::move(*child));
  while (!is_ready()) {
    if (!children_.back().running() || std::chrono::steady_clock::now() > start_by_) {
      return fail(ErrorCode::kUnavailable, std::string(name) + " did not start:\n" + end_of(log));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return {};
}

Result<void> Stage::start_redis(const Options& options) {
  const std::string own = options.bin_dir + "/redis-server";
  const std::string program = ::access(own.c_str(), X_OK) == 0 ? own : "redis-server";
  auto client = directory::Client::create({.address = redis()});
  DIAPHANE_TRY(client);
  directory::Sessions sessions(**client);
  return start("redis", program,
               {"--port", "0", "--unixsocket", folder_ + "/redis.sock", "--save", "",
                "--appendonly", "no", "--dir", folder_},
               [&] { return sessions.reachable(); });
}

Result<void> Stage::start_renderd(const Options& options) {
  const std::string socket = "unix:" + folder_ + "/renderd.sock";
  std::vector<std::string> arguments{"--worker-id=load",
                                     "--redis=" + redis(),
                                     "--grpc-address=" + socket,
                                     "--advertise=" + socket,
                                     "--admin-port=" + std::to_string(renderd_admin_),
                                     "--volume-dir=" + store(),
                                     "--engine=" + options.engine,
                                     "--slots=" + std::to_string(options.slots)};
  arguments.insert(arguments.end(), options.renderd_options.begin(), options.renderd_options.end());
  return start("renderd", options.bin_dir + "/diaphane-renderd", arguments,
               [&] { return ready(renderd_admin_); });
}

Result<void> Stage::start_gateway(const Options& options) {
  return start("gateway", options.bin_dir + "/diaphane-gateway",
               {"--redis=" + redis(), "--stream-port=" + std::to_string(stream_port_),
                "--admin-port=" + std::to_string(gateway_admin_), "--public-url=" + origin_},
               [&] { return ready(gateway_admin_); });
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
