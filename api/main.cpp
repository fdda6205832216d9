// diaphane-api: the REST API. Wiring only.
#include <sodium.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "api/admin_command.h"
#include "api/archive/zip_writer.h"
#include "api/handlers/preset_format.h"
#include "api/handlers/routes.h"
#include "api/http/executor.h"
#include "api/http/listener.h"
#include "api/http/request_metrics.h"
#include "api/mail/transport.h"
#include "api/postgres/account_change_repository.h"
#include "api/postgres/account_repository.h"
#include "api/postgres/administration_repository.h"
#include "api/postgres/anonymise_repository.h"
#include "api/postgres/data_set_repository.h"
#include "api/postgres/migrate.h"
#include "api/postgres/preset_repository.h"
#include "api/postgres/privacy_repository.h"
#include "api/postgres/recording_repository.h"
#include "api/postgres/report_repository.h"
#include "api/postgres/second_factor_repository.h"
#include "api/postgres/sharing_repository.h"
#include "api/service/housekeeping.h"
#include "api/stream/worker_stills.h"
#include "common/clock.h"
#include "common/config.h"
#include "common/log.h"
#include "common/postgres/address.h"
#include "common/service/admin_server.h"
#include "common/service/core_files.h"
#include "common/service/freed_memory.h"
#include "common/service/signals.h"
#include "common/wire/inner_tls.h"
#include "directory/client.h"
#include "directory/links.h"
#include "directory/sessions.h"
#include "volume/store.h"
#include "volume/volume.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

constexpr int kExitUnavailable = 69;  ///< sysexits.h: a dependency is unavailable at the start
constexpr int kWorkers = 16;
constexpr std::size_t kWaiting = 256;
constexpr int kConnections = 12;
constexpr int kHashingSlots = 2;

int run_migrate(ConfigReader& in) {
  const std::string url = postgres::read_url(in, wire::read_plain_allowed(in));
  const std::string directory =
      in.directory("migrations", "directory with the NNNN_name.up.sql and .down.sql files");
  const auto steps = static_cast<int>(in.integer(
      "steps", "number of migrations to run; 0 means all (up) or one (down)", 0, 1000, 0));
  const auto& words = in.words();
  if (words.size() != 2 || (words[1] != "up" && words[1] != "down"))
    in.mistake("usage: diaphane-api migrate up | down");
  if (auto done = in.finish("diaphane-api migrate up|down: apply or revert database migrations"))
    return *done;
  const auto applied =
      migrate(url, directory, words[1] == "up" ? Direction::kUp : Direction::kDown, steps);
  if (!applied) {
    std::fprintf(stderr, "%s\n", applied.error().message.c_str());
    return applied.error().code == ErrorCode::kUnavailable ? kExitUnavailable : 1;
  }
  for (const std::string& name : *applied) std::printf("%s %s\n", words[1].c_str(), name.c_str());
  if (applied->empty()) std::printf("nothing to do\n");
  return 0;
}

struct Settings {
  std::string postgres, redis, public_url, upload_dir, volume_dir, cache_dir, mail, mail_from;
  std::string sample_token, admin_address, fleet;
  std::optional<SealingKey> factor_key;
  std::uint16_t api_port = 0, admin_port = 0;
  DataSets::Options data_sets;
  std::int64_t export_total_bytes = 0;
  std::chrono::milliseconds background{5000};
  int visitor_percent = kVisitorPercent;
  wire::InnerTls tls;
};

Settings read_settings(ConfigReader& in) {
  Settings s;
  s.redis = in.text("redis", "Redis address: host:port, rediss://host:port for TLS, or unix:PATH");
  s.fleet = in.text("fleet", "RenderFleet to scale up when no slot is free", "");
  s.visitor_percent = static_cast<int>(in.integer(
      "visitor-share", "maximum percentage of all slots that visitors without an account may use",
      0, 100, kVisitorPercent));
  s.tls = wire::read_inner_tls(in, wire::Role::kApi);
  wire::check_address(in, "redis", s.redis, s.tls);
  s.postgres = postgres::read_url(in, s.tls.plain_allowed);
  s.api_port = in.port("api-port",
                       "port of the REST API; listens on 127.0.0.1 only, behind the reverse proxy");
  s.admin_port = in.port("admin-port", "port of the admin server (/metrics, /healthz, /readyz)");
  s.admin_address =
      in.text("admin-address", "address that the admin server listens on", "127.0.0.1");
  s.public_url = in.text("public-url", "origin that browsers use, such as https://host[:port]");
  s.upload_dir = in.directory("upload-dir", "directory for uploads");
  s.volume_dir = in.directory("volume-dir", "directory of the volume store");
  s.cache_dir =
      in.directory("cache-dir", "directory of the cached images that the reverse proxy serves");
  s.mail = in.text("mail", "where emails go: file:DIRECTORY or smtp://[user:password@]host:port");
  s.mail_from = in.text("mail-from", "sender of the emails: address or Name <address>");
  s.data_sets.max_upload_bytes =
      in.integer("max-upload-mb", "maximum size of an upload, in MiB", 1, 1'000'000, 8192) << 20;
  s.data_sets.upload_life = std::chrono::seconds(
      in.integer("upload-expiry-s", "time after which an inactive upload expires, in seconds", 1,
                 30 * 86400, 86400));
  s.data_sets.reserve_bytes =
      in.integer("disk-reserve-mb", "disk space that uploads must leave free, in MiB", 0, 1'000'000,
                 1024)
      << 20;
  s.data_sets.limits.unprocessed = static_cast<int>(in.integer(
      "most-unprocessed", "maximum number of unprocessed scans per account", 1, 100'000, 50));
  s.data_sets.limits.all = static_cast<int>(
      in.integer("most-data-sets", "maximum number of scans per account", 1, 1'000'000, 2000));
  s.export_total_bytes =
      in.integer("exports-mb", "maximum disk space for all exports together, in MiB", 1, 10'000'000,
                 20'480)
      << 20;
  s.background = std::chrono::milliseconds(
      in.integer("background-ms", "maximum time between two runs of a background task, in ms", 50,
                 5000, 5000));
  const std::string token_file =
      in.text("sample-token", "file with the token that allows uploading the public sample", "");
  if (!token_file.empty()) {
    std::ifstream file(token_file);
    if (!(file >> s.sample_token) || s.sample_token.size() < 32) {
      in.mistake("--sample-token: the file does not exist or has fewer than 32 characters");
    }
  }
  const std::string key_file = in.text(
      "factor-key", "file with the 64 hexadecimal digits of the key that encrypts TOTP secrets");
  if (auto key = SealingKey::read(key_file)) {
    s.factor_key = *std::move(key);
  } else if (!key_file.empty()) {
    in.mistake("--factor-key: " + key.error().message);
  }
  const bool origin = s.public_url.starts_with("http://") || s.public_url.starts_with("https://");
  if (!s.public_url.empty() && (!origin || s.public_url.ends_with('/'))) {
    in.mistake("--public-url: must be an origin without a path, such as https://host[:port]");
  }
  return s;
}

int serve(const Settings& settings, service::StopSignal& stop) {
  const SystemClock clock;
  auto transport = open_mail_transport(settings.mail, settings.mail_from);
  if (!transport) {
    std::fprintf(stderr, "%s\n", transport.error().message.c_str());
    return kExitConfig;
  }
  auto redis_client = directory::Client::create({.address = settings.redis, .tls = settings.tls});
  if (!redis_client) {
    std::fprintf(stderr, "--redis: %s\n", redis_client.error().message.c_str());
    return kExitConfig;
  }
  directory::Sessions placed(**redis_client, {.visitor_percent = settings.visitor_percent},
                             settings.fleet);
  Database database(settings.postgres, kConnections);
  AccountRepository account_store(database);
  DataSetRepository data_set_store(database);
  AccountChangeRepository account_change_store(database);
  AdministrationRepository administration_store(database);
  RenderTimeRepository render_time_store(database);
  PrivacyRepository privacy_store(database);
  MailRepository mail_store(database);

  // Starts first, so that a hanging start can be examined. Ready only once the listener is open.
  std::atomic<bool> serving = false;
  auto admin =
      service::AdminServer::start({.address = settings.admin_address,
                                   .port = settings.admin_port,
                                   .program = "api",
                                   .checks = {{"postgres", [&] { return database.reachable(); }},
                                              {"redis", [&] { return placed.reachable(); }},
                                              {"listener", [&] { return serving.load(); }}},
                                   .details = {}});
  if (!admin) {
    std::fprintf(stderr, "%s\n", admin.error().message.c_str());
    return kExitUnavailable;
  }
  RequestMetrics metrics((*admin)->registry());

  PasswordHasher hasher(kHashingSlots);
  SecondFactorRepository factor_store(database);
  const SealingKey& factor_key = settings.factor_key.value();
  CodeCheck code_check(factor_store, account_store, factor_key, clock,
                       {.public_url = settings.public_url});
  Accounts accounts(account_store, hasher, code_check, factor_key, clock,
                    {.public_url = settings.public_url});
  SecondFactors second_factors(factor_store, accounts, code_check, factor_key, clock, {});
  AccountChanges account_changes(account_change_store, account_store, accounts, hasher, placed,
                                 clock, {.public_url = settings.public_url});
  UploadFiles files(settings.upload_dir);
  DataSets data_sets(data_set_store, placed, clock, settings.data_sets,
                     [&] { return files.free_bytes(); });
  // Uploads that were announced before the disk filled up may use half of the reserve.
  Uploads uploads(data_set_store, files, clock, settings.data_sets.upload_life,
                  settings.data_sets.reserve_bytes / 2);
  RenderTime render_time(render_time_store, placed, placed, clock);
  PresetRepository preset_store(database);
  // Uses the owner's default preset. If there is none or it is unavailable, uses the volume's
  // default appearance.
  const auto first_scene = [&](const std::string& data_set) {
    const auto scene = preset_store.default_scene(data_set);
    return scene && !scene->empty() ? scene_bytes(*scene) : std::string();
  };
  Sessions sessions(data_sets, placed, render_time, first_scene);
  Administration administration(administration_store, placed, placed, clock);
  const std::string export_dir = settings.cache_dir + "/exports";
  Exports exports(privacy_store, ZipWriter::create, clock,
                  {.volumes = settings.volume_dir,
                   .pictures = settings.cache_dir + "/presets",
                   .exports = export_dir,
                   .reserve_bytes = settings.data_sets.reserve_bytes,
                   .total_bytes = settings.export_total_bytes});
  AccountDeletion deletion(privacy_store, accounts, placed, clock);
  directory::Links link_store(**redis_client);
  RecordingRepository recording_store(database);
  Recordings recordings(recording_store, clock);
  SharingRepository sharing_store(database);
  const SharingParts shared{data_sets, sharing_store, account_store, placed, clock};
  Sharing sharing(shared, {.public_url = settings.public_url});
  Visits visits(shared, {}, first_scene);
  Presets presets(data_sets, preset_store, clock);
  ReportRepository report_store(database);
  Reports reports(data_sets, presets, report_store, account_store, clock,
                  [&](const std::string& data_set) { sharing.end_lost_sessions(data_set); });
  LiveLinks live_links(data_sets, placed, link_store, account_store, clock, {});
  stream::WorkerStills stills(placed, settings.tls);
  Thumbnails thumbnails(data_sets, stills, settings.cache_dir);
  PresetPictures preset_pictures(data_sets, presets, preset_store, stills, clock,
                                 settings.cache_dir, scene_bytes);

  CutRepository cut_store(database);
  Anonymise anonymise(data_sets, cut_store, thumbnails, placed, clock, [&](const std::string& id) {
    const auto header = volume::read_header(settings.volume_dir + "/" + id);
    return header ? header->content_hash : std::string();
  });

  Mailer mailer(mail_store, **transport, clock);
  Disposer disposer(data_set_store, files, thumbnails, preset_pictures, settings.volume_dir,
                    export_dir);
  const auto at_most = [&](std::chrono::milliseconds period) {
    return std::min(period, settings.background);
  };
  Periodic send_mails("mail", at_most(2s), [&] {
    const auto [sent, failed] = mailer.send_due();
    metrics.mails(sent, failed);
  });
  Periodic make_pictures("preset thumbnails", at_most(5s), [&] {
    while (preset_pictures.make_next()) {
    }
  });
  Periodic dispose("disposal", at_most(5s), [&] {
    (void)data_set_store.expire_uploads(clock.wall());
    const int gone = disposer.dispose();
    metrics.disposed(gone);
    if (gone > 0) make_pictures.wake();  // a picture may have waited for its predecessor's deletion
    // Removes partial volumes that a killed ingestd left behind, even while no ingestd runs.
    (void)volume::sweep_unfinished(settings.volume_dir);
  });
  Periodic end_visits("visits", at_most(5s), [&] { visits.expire(); });
  Periodic end_browsers("expired web sessions", at_most(5s),
                        [&] { account_changes.end_expired_browsers(); });
  Periodic tidy("tidying", 10min, [&] {
    (void)account_store.tidy(clock.wall());
    (void)recording_store.expire(clock.wall());
  });
  Periodic count_render_time("rendering time", at_most(2s), [&] { render_time.poll(); });
  Periodic make_exports("exports", at_most(2s), [&] { exports.poll(); });
  exports.on_request([&] { make_exports.wake(); });
  deletion.on_removal([&] {
    dispose.wake();
    send_mails.wake();
  });
  accounts.on_mail([&] { send_mails.wake(); });
  accounts.on_sign_out([&] { account_changes.end_expired_browsers(); });
  second_factors.on_sign_out([&] { account_changes.end_expired_browsers(); });
  account_changes.on_mail([&] { send_mails.wake(); });
  code_check.on_mail([&] { send_mails.wake(); });
  second_factors.on_mail([&] { send_mails.wake(); });
  sharing.on_mail([&] { send_mails.wake(); });
  data_sets.on_disposal([&] { dispose.wake(); });
  anonymise.on_disposal([&] { dispose.wake(); });
  presets.on_picture([&] {
    dispose.wake();
    make_pictures.wake();
  });
  uploads.on_disposal([&] { dispose.wake(); });

  Executor executor(kWorkers, kWaiting);
  RequestRouter router(accounts, {.public_url = settings.public_url,
                                  .sample_token = settings.sample_token,
                                  .measure = [&](const Measured& request) {
                                    metrics.measured(request);
                                    metrics.set_waiting(static_cast<double>(executor.waiting()));
                                  }});
  router.add(account_routes(accounts, render_time, router));
  router.add(account_change_routes(account_changes, router));
  router.add(second_factor_routes(second_factors));
  router.add(admin_routes(administration));
  router.add(privacy_routes(exports, deletion, router));
  router.add(data_set_routes(data_sets, thumbnails));
  router.add(upload_routes(uploads, data_sets));
  router.add(session_routes(sessions));
  router.add(live_routes(live_links, router));
  router.add(recording_routes(recordings));
  router.add(sharing_routes(sharing, router));
  router.add(anonymise_routes(anonymise));
  router.add(visit_routes(visits));
  router.add(preset_routes(presets, preset_pictures));
  router.add(report_routes(reports));

  auto listener = Listener::open(router, executor, {.port = settings.api_port});
  if (!listener) {
    std::fprintf(stderr, "%s\n", listener.error().message.c_str());
    return kExitUnavailable;
  }
  serving = true;
  log::info("serving", {{"api_port", settings.api_port}});

  stop.wait();
  log::info("draining");
  (*admin)->set_draining();
  (*listener)->drain(1500ms);
  log::info("stopped");
  // All requests are answered and all data is stored. Closing the admin port would take up to two
  // more seconds, which the process manager may not allow.
  std::quick_exit(0);
}

}  // namespace
}  // namespace diaphane::api

int main(int argc, char** argv) {
  using namespace diaphane;
  // For parts of uploads, slices and images, and for the 19 MB of each password hash.
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
