// diaphane-operator: wiring only.
#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>

#include "common/config.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/service/admin_server.h"
#include "common/service/signals.h"
#include "common/wire/inner_tls.h"
#include "operator/act/retire.h"
#include "operator/controller.h"
#include "operator/kube/cpprest_transport.h"

namespace {

using namespace diaphane;

constexpr int kExitUnavailable = 69;  // sysexits.h: EX_UNAVAILABLE
constexpr int kExitNotAllowed = 77;   // EX_NOPERM
/// The lease went to another: nothing is finished, nothing is given back.
constexpr int kExitLost = 75;  // EX_TEMPFAIL
constexpr char kAccountDir[] = "/var/run/secrets/kubernetes.io/serviceaccount";

struct Options {
  kube::Access access;
  std::string redis;
  wire::InnerTls tls;
  std::string admin_address;
  std::uint16_t admin_port = 0;
  fleet::Controller::Options controller;
};

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

std::map<std::string, std::string> pod_environment() {
  std::map<std::string, std::string> all;
  for (const char* name : {"KUBERNETES_SERVICE_HOST", "KUBERNETES_SERVICE_PORT"}) {
    if (const char* value = std::getenv(name)) all.emplace(name, value);
  }
  return all;
}

kube::Access read_access(ConfigReader& in) {
  const auto pod = kube::access_of_pod(pod_environment(), kAccountDir);
  kube::Access access = pod.value_or(kube::Access{});
  access.name_space =
      in.text("namespace", "whose fleets are seen to; default: the pod's", access.name_space);
  access.server =
      in.text("kube-server", "API server, https://host:port; default: the pod's", access.server);
  access.token_file =
      in.text("kube-token-file", "who asks; default: the pod's account", access.token_file);
  access.ca_file =
      in.text("kube-ca-file", "who signed the API server's certificate; default: as in the pod",
              access.ca_file);
  if (access.server.empty()) in.mistake("--kube-server is missing, and this is no pod");
  if (access.name_space.empty()) in.mistake("--namespace is missing, and this is no pod");
  return access;
}

std::optional<int> read_options(ConfigReader& in, Options& options) {
  options.access = read_access(in);
  options.redis = in.text("redis", "host:port, or rediss://host:port with TLS");
  options.tls = wire::read_inner_tls(in);
  wire::check_address(in, "redis", options.redis, options.tls);
  options.admin_address = in.text("admin-address", "of metrics and health", "127.0.0.1");
  options.admin_port = in.port("admin-port", "metrics and health");
  options.controller.name_space = options.access.name_space;
  options.controller.all_pods =
      in.one_of("watch-all-pods", "1: GPUs held by pods of other namespaces count", {"0", "1"},
                "0") == "1";
  kube::Leader::Options& leader = options.controller.leader;
  leader.name = in.text("lease", "name of the Lease that the leader holds", "diaphane-operator");
  leader.lease.identity =
      in.text("identity", "of this process in the Lease", host_name() + "_" + random_hex(4));
  leader.path = "/apis/coordination.k8s.io/v1/namespaces/" + options.access.name_space + "/leases";
  // Nothing is given back and nothing ended in order: another may be writing already.
  leader.lost = [] { std::_Exit(kExitLost); };
  if (!in.words().empty()) in.mistake("a word alone: retire");
  return in.finish(
      "diaphane-operator: render pods of a Kubernetes namespace (retire: the end of a fleet)");
}

int run_retire(ConfigReader& in) {
  const kube::Access access = read_access(in);
  fleet::RetireOptions options;
  options.name_space = access.name_space;
  options.fleet = in.text("fleet", "RenderFleet that goes, with all its workers");
  options.grace =
      static_cast<double>(in.integer("grace-s", "so long an operator may drain it", 0, 86400, 120));
  options.clock = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  options.pause = [] { std::this_thread::sleep_for(std::chrono::seconds(1)); };
  if (auto done = in.finish("diaphane-operator retire: deletes a fleet and waits for its end")) {
    return *done;
  }
  log::start("operator");
  const auto transport = kube::make_cpprest_transport(access);
  kube::Api api(*transport, "diaphane-retire");
  const auto done = fleet::retire(api, options);
  if (done) return 0;
  log::error("not_retired", {{"message", done.error().message}});
  return kExitNotAllowed;
}

int serve(const Options& options) {
  service::StopSignal stop;
  auto redis =
      api::redis::Client::create({.address = options.redis, .connections = 2, .tls = options.tls});
  if (!redis) {
    std::fprintf(stderr, "--redis: %s\n", redis.error().message.c_str());
    return kExitConfig;
  }
  const auto transport = kube::make_cpprest_transport(options.access);
  std::atomic<fleet::Controller*> now{nullptr};
  const auto asks = [&now](bool (fleet::Controller::*what)() const) {
    return [&now, what] {
      const fleet::Controller* controller = now;
      return controller && (controller->*what)();
    };
  };
  service::AdminServer::Options admin_options;
  admin_options.address = options.admin_address;
  admin_options.port = options.admin_port;
  admin_options.program = "operator";
  admin_options.checks = {{"listed", asks(&fleet::Controller::listed)},
                          {"kubernetes", asks(&fleet::Controller::connected)},
                          {"redis", asks(&fleet::Controller::redis_answers)}};
  admin_options.details = [leads = asks(&fleet::Controller::leads)] {
    return std::string(R"({"leader": )") + (leads() ? "true}" : "false}");
  };
  auto admin = service::AdminServer::start(std::move(admin_options));
  if (!admin) {
    std::fprintf(stderr, "--admin-port: %s\n", admin.error().message.c_str());
    return kExitUnavailable;
  }
  fleet::Metrics metrics((*admin)->registry());
  {
    fleet::Controller controller(options.controller, *transport, **redis, metrics);
    now = &controller;
    log::info("started", {{"namespace", options.access.name_space}});
    const int signal = stop.wait();
    log::info("draining", {{"signal", signal}});
    (*admin)->set_draining();
    now = nullptr;
  }
  log::info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Lists are large and short-lived: what they took is given back.
  mallopt(M_ARENA_MAX, 2);
  ConfigReader in(argc, argv);
  if (in.words() == std::vector<std::string>{"retire"}) return run_retire(in);
  Options options;
  if (auto done = read_options(in, options)) return *done;
  log::start("operator");
  return serve(options);
}
