// Entry point of diaphane-operator, which only connects its parts.
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
/// Another process has the lease, so the process exits without finishing or releasing anything.
constexpr int kExitLost = 75;  // EX_TEMPFAIL
constexpr char kAccountDir[] = "/var/run/secrets/kubernetes.io/serviceaccount";

struct Options {
  kube::Access access;
  std::string redis;
  wire::InnerTls tls;
  service::AdminServer::Options admin;
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
  access.name_space = in.text("namespace", "namespace of the fleets (default: the pod's namespace)",
                              access.name_space);
  access.server =
      in.text("kube-server", "URL of the API server, https://host:port (default: from the pod)",
              access.server);
  access.token_file =
      in.text("kube-token-file", "file with the bearer token (default: the pod's service account)",
              access.token_file);
  access.ca_file = in.text("kube-ca-file", "CA certificate of the API server (default: the pod's)",
                           access.ca_file);
  if (access.server.empty()) in.mistake("--kube-server is missing (required outside a pod)");
  if (access.name_space.empty()) in.mistake("--namespace is missing (required outside a pod)");
  return access;
}

std::optional<int> read_options(ConfigReader& in, Options& options) {
  options.access = read_access(in);
  options.tls = wire::read_inner_tls(in, wire::Role::kOperator);
  options.redis = wire::read_redis(in, options.tls);
  options.admin = service::read_admin_options(in, "operator");
  options.controller.name_space = options.access.name_space;
  options.controller.all_pods =
      in.one_of("watch-all-pods", "1 also counts GPUs that pods of other namespaces use",
                {"0", "1"}, "0") == "1";
  kube::Leader::Options& leader = options.controller.leader;
  leader.name = in.text("lease", "name of the Lease for leader election", "diaphane-operator");
  leader.lease.identity = in.text("identity", "identity of this process in the Lease",
                                  host_name() + "_" + random_hex(4));
  leader.path = "/apis/coordination.k8s.io/v1/namespaces/" + options.access.name_space + "/leases";
  // Exits without an orderly shutdown, because another process may already be writing.
  leader.lost = [] { std::_Exit(kExitLost); };
  if (!in.words().empty()) in.mistake("unknown command (the only command is: retire)");
  return in.finish(
      "diaphane-operator: manages the render fleets of a Kubernetes namespace\n"
      "diaphane-operator retire: deletes a fleet and waits until it is gone");
}

int run_retire(ConfigReader& in) {
  const kube::Access access = read_access(in);
  fleet::RetireOptions options;
  options.name_space = access.name_space;
  options.fleet = in.text("fleet", "RenderFleet to delete, with all its workers");
  options.grace = static_cast<double>(in.integer(
      "grace-s", "seconds that the operator may take to drain the fleet", 0, 86400, 120));
  options.clock = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  options.pause = [] { std::this_thread::sleep_for(std::chrono::seconds(1)); };
  if (auto done =
          in.finish("diaphane-operator retire: deletes a fleet and waits until it is gone")) {
    return *done;
  }
  log::start("operator");
  const auto transport = kube::make_cpprest_transport(access);
  kube::Api api(*transport, "diaphane-retire");
  const auto done = fleet::retire(api, options);
  if (done) return 0;
  log::error("retire_failed", {{"message", done.error().message}});
  return kExitNotAllowed;
}

int serve(const Options& options) {
  service::StopSignal stop;
  auto redis =
      directory::Client::create({.address = options.redis, .connections = 2, .tls = options.tls});
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
  service::AdminServer::Options admin_options = options.admin;
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
  // Lists are large and short-lived. A limit on arenas returns their memory to the system.
  mallopt(M_ARENA_MAX, 2);
  ConfigReader in(argc, argv);
  if (in.words() == std::vector<std::string>{"retire"}) return run_retire(in);
  Options options;
  if (auto done = read_options(in, options)) return *done;
  log::start("operator");
  return serve(options);
}
