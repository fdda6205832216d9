// diaphane-api: the REST API. Wiring only.
#include <sodium.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "api/accounts/routes.h"
#include "api/admin_command.h"
#include "api/administration/routes.h"
#include "api/annotations/routes.h"
#include "api/background_tasks.h"
#include "api/environments/panorama_child.h"
#include "api/environments/routes.h"
#include "api/http/executor.h"
#include "api/http/listener.h"
#include "api/http/request_metrics.h"
#include "api/mail/transport.h"
#include "api/pacs/routes.h"
#include "api/presets/routes.h"
#include "api/privacy/routes.h"
#include "api/scans/routes.h"
#include "api/services.h"
#include "api/sessions/routes.h"
#include "api/settings.h"
#include "api/shared/migrate.h"
#include "api/sharing/routes.h"
#include "api/studies/routes.h"
#include "common/clock.h"
#include "common/config.h"
#include "common/log.h"
#include "common/postgres/address.h"
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

constexpr int kExitUnavailable = 69;  ///< sysexits.h: a dependency is unavailable at the start
constexpr int kWorkers = 16;
constexpr std::size_t kWaiting = 256;

int run_migrate(ConfigReader& in) {
  const std::string url = postgres::read_url(in, wire::read_plain_allowed(in));
  const std::string directory =
      in.directory("migrations", "directory with the NNNN_name.up.sql and .down.sql files");
  const auto steps = static_cast<int>(in.integer(
      "steps", "number of migrations to run (0 = all for up, one for down)", 0, 1000, 0));
  const auto& positional = in.words();
  if (positional.size() != 2 || (positional[1] != "up" && positional[1] != "down"))
    in.mistake("usage: diaphane-api migrate up | down");
  if (auto done = in.finish("diaphane-api migrate up|down: apply or revert database migrations"))
    return *done;
  const auto applied =
      migrate(url, directory, positional[1] == "up" ? Direction::kUp : Direction::kDown, steps);
  if (!applied) {
    std::fprintf(stderr, "%s\n", applied.error().message.c_str());
    return applied.error().code == ErrorCode::kUnavailable ? kExitUnavailable : 1;
  }
  for (const std::string& name : *applied)
    std::printf("%s %s\n", positional[1].c_str(), name.c_str());
  if (applied->empty()) std::printf("nothing to do\n");
  return 0;
}

int failed(const Error& why, int exit_code) {
  std::fprintf(stderr, "%s\n", why.message.c_str());
  return exit_code;
}

Result<std::unique_ptr<service::AdminServer>> start_admin(const Settings& settings,
                                                          Database& database,
                                                          directory::Sessions& placed,
                                                          const std::atomic<bool>& serving) {
  service::AdminServer::Options options = settings.admin;
  options.checks = {{"postgres", [&] { return database.reachable(); }},
                    {"redis", [&] { return placed.reachable(); }},
                    {"listener", [&] { return serving.load(); }}};
  return service::AdminServer::start(std::move(options));
}

void add_routes(RequestRouter& router, Services& services, const Clock& clock) {
  auto& [account, data_set, session, privacy, shared, picture, study, archive] = services;
  router.add(account_routes(account.accounts, session.render_time, router));
  router.add(account_change_routes(account.changes, router));
  router.add(second_factor_routes(account.second_factors));
  router.add(api_token_routes(account.tokens));
  router.add(admin_routes(session.administration));
  router.add(privacy_routes(privacy.exports, privacy.deletion, router));
  router.add(data_set_routes(data_set.data_sets, picture.thumbnails));
  router.add(scan_export_routes(data_set.exports));
  router.add(upload_routes(data_set.uploads, data_set.data_sets));
  router.add(alignment_routes(data_set.alignments));
  router.add(session_routes(session.sessions));
  router.add(live_routes(shared.live_links, router));
  router.add(recording_routes(shared.recordings));
  router.add(sharing_routes(shared.sharing, router));
  router.add(anonymise_routes(picture.anonymise));
  router.add(label_routes(picture.labels));
  router.add(visit_routes(shared.visits, picture.thumbnails));
  router.add(environment_routes(shared.environments));
  router.add(annotation_routes(shared.annotations, shared.visits));
  router.add(preset_routes(shared.presets, picture.preset_pictures));
  router.add(report_routes(shared.reports));
  router.add(study_routes(study.studies, study.participations, clock));
  router.add(participant_routes(study.participations));
  router.add(tour_routes(study.studies, shared.visits));
  router.add(archive_routes(archive.archives, account.accounts));
}

int serve(const Settings& settings, service::StopSignal& stop) {
  const SystemClock clock;
  auto transport = open_mail_transport(settings.mail, settings.mail_from);
  if (!transport) return failed(transport.error(), kExitConfig);
  auto redis = directory::Client::create({.address = settings.redis, .tls = settings.tls});
  if (!redis) {
    std::fprintf(stderr, "--redis: %s\n", redis.error().message.c_str());
    return kExitConfig;
  }
  directory::Sessions placed(**redis, {.visitor_percent = settings.visitor_percent},
                             settings.fleet);
  Stores stores(settings.postgres);

  // The admin port opens first, so that a hanging start can be examined.
  std::atomic<bool> serving = false;
  auto admin = start_admin(settings, stores.database, placed, serving);
  if (!admin) return failed(admin.error(), kExitUnavailable);
  RequestMetrics metrics((*admin)->registry());

  Signals signals;
  const Backends backends{.settings = settings,
                          .clock = clock,
                          .redis = **redis,
                          .placed = placed,
                          .stores = stores,
                          .signals = signals};
  Services services(backends);
  const BackgroundTasks tasks(backends, services, **transport, metrics);
  Executor executor(kWorkers, kWaiting);
  RequestRouter router(services.account.accounts,
                       {.public_url = settings.public_url,
                        .sample_token = settings.sample_token,
                        .tokens = &services.account.tokens,
                        .measure = [&](const Measured& request) {
                          metrics.measured(request);
                          metrics.set_waiting(static_cast<double>(executor.waiting()));
                        }});
  add_routes(router, services, clock);

  auto listener = Listener::open(router, executor, {.port = settings.api_port});
  if (!listener) return failed(listener.error(), kExitUnavailable);
  serving = true;
  log::info("serving", {{"api_port", settings.api_port}});

  service::drain_on_stop(stop, **admin, [&] { (*listener)->drain(1500ms); });
}

}  // namespace
}  // namespace diaphane::api

int main(int argc, char** argv) {
  using namespace diaphane;
  if (argc == 2 && std::string_view(argv[1]) == api::kPanoramaWord) {
    return api::run_panorama_child();
  }
  // Freed memory may hold parts of uploads, slices and images, and 19 MB of each password hash.
  service::overwrite_freed_memory();
  if (sodium_init() < 0) return 70;
  service::forbid_core_files();
  ConfigReader in(argc, argv);
  if (!in.words().empty() && in.words().front() == "migrate") return api::run_migrate(in);
  if (!in.words().empty() && in.words().front() == "admin") return api::run_admin(in);
  const api::Settings settings = api::read_settings(in);
  if (!in.words().empty()) in.mistake("unknown argument " + in.words().front() + " (see --help)");
  if (auto done = in.finish(
          "diaphane-api: the REST API server\n\n"
          "Other commands: diaphane-api migrate up|down, diaphane-api admin (see their --help)")) {
    return *done;
  }
  log::start("api");
  service::StopSignal stop;
  return api::serve(settings, stop);
}
