#include "api/load/gateway_host.h"

#include <cstdio>

#include "api/redis/client.h"
#include "api/redis/sessions.h"
#include "api/stream/gateway.h"
#include "common/config.h"
#include "common/log.h"
#include "common/service/admin_server.h"
#include "common/service/signals.h"

namespace diaphane::api::load {
namespace {

constexpr int kExitUnavailable = 69;  // sysexits.h

int refuse(const Error& why, int code) {
  std::fprintf(stderr, "%s\n", why.message.c_str());
  return code;
}

}  // namespace

int serve_gateway(const GatewayHost& settings) {
  log::start("gateway");
  service::StopSignal stop;
  auto client = redis::Client::create({.address = settings.redis});
  if (!client) return refuse(client.error(), kExitConfig);
  redis::Sessions sessions(**client);
  auto admin =
      service::AdminServer::start({.port = settings.admin_port,
                                   .program = "gateway",
                                   .checks = {{"redis", [&] { return sessions.reachable(); }}},
                                   .details = {}});
  if (!admin) return refuse(admin.error(), kExitUnavailable);
  auto gateway =
      stream::Gateway::start({.port = settings.stream_port, .public_url = settings.public_url},
                             sessions, sessions, sessions, (*admin)->registry());
  if (!gateway) return refuse(gateway.error(), kExitUnavailable);
  log::info("serving", {{"stream_port", settings.stream_port}});
  stop.wait();
  (*gateway)->stop(std::chrono::milliseconds(500));
  return 0;
}

}  // namespace diaphane::api::load
