// diaphane-gateway: the WebSocket gateway of the stream. Wiring only. It is a separate process from
// the REST API, so that a crash of the API does not end any stream.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include "api/stream/gateway.h"
#include "common/config.h"
#include "common/log.h"
#include "common/service/admin_server.h"
#include "common/service/core_files.h"
#include "common/service/drain.h"
#include "common/service/freed_memory.h"
#include "common/service/signals.h"
#include "common/wire/inner_tls.h"
#include "directory/client.h"
#include "directory/sessions.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

constexpr int kExitUnavailable = 69;  ///< sysexits.h: a port cannot be opened
constexpr auto kGrace = 500ms;  ///< time for viewers to close after they were asked to reconnect

struct GatewaySettings {
  std::string redis, public_url;
  std::uint16_t stream_port = 0;
  service::AdminServer::Options admin;
  wire::InnerTls tls;
};

GatewaySettings read_settings(ConfigReader& in) {
  GatewaySettings s;
  s.tls = wire::read_inner_tls(in, wire::Role::kGateway);
  s.redis = wire::read_redis(in, s.tls);
  s.stream_port = in.port(
      "stream-port", "port for WebSockets; listens on 127.0.0.1 only, behind the reverse proxy");
  s.admin = service::read_admin_options(in, "gateway");
  s.public_url = in.text("public-url", "origin that browsers use, such as https://host[:port]");
  return s;
}

int refuse(const Error& why, int code) {
  std::fprintf(stderr, "%s\n", why.message.c_str());
  return code;
}

int serve(const GatewaySettings& settings, service::StopSignal& stop) {
  auto redis_client = directory::Client::create({.address = settings.redis, .tls = settings.tls});
  if (!redis_client) return refuse(redis_client.error(), kExitConfig);
  directory::Sessions placed(**redis_client);

  // The admin port opens first, so that a hanging start can be examined.
  std::atomic<bool> serving = false;
  service::AdminServer::Options admin_options = settings.admin;
  admin_options.checks = {{"redis", [&] { return placed.reachable(); }},
                          {"listener", [&] { return serving.load(); }}};
  auto admin = service::AdminServer::start(std::move(admin_options));
  if (!admin) return refuse(admin.error(), kExitUnavailable);

  auto gateway = stream::Gateway::start(
      {.port = settings.stream_port, .public_url = settings.public_url, .tls = settings.tls},
      placed, placed, placed, (*admin)->registry());
  if (!gateway) {
    const bool mistake = gateway.error().code == ErrorCode::kInvalid;
    return refuse(gateway.error(), mistake ? kExitConfig : kExitUnavailable);
  }
  serving = true;
  log::info("serving", {{"stream_port", settings.stream_port}});

  service::drain_on_stop(stop, **admin, [&] { (*gateway)->stop(kGrace); });
}

}  // namespace
}  // namespace diaphane::api

int main(int argc, char** argv) {
  using namespace diaphane;
  service::overwrite_freed_memory();  // freed memory may contain pictures and slices
  service::forbid_core_files();
  ConfigReader in(argc, argv);
  const api::GatewaySettings settings = api::read_settings(in);
  if (!in.words().empty()) in.mistake("unknown argument " + in.words().front() + " (see --help)");
  if (auto done = in.finish("diaphane-gateway: the WebSocket gateway for image streams"))
    return *done;
  log::start("gateway");
  service::StopSignal stop;
  return api::serve(settings, stop);
}
