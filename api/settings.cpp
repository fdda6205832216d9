#include "api/settings.h"

#include <fstream>

#include "api/accounts/accounts.h"
#include "api/shared/audit.h"
#include "common/postgres/address.h"

namespace diaphane::api {
namespace {

void read_databases(ConfigReader& in, Settings& s) {
  s.fleet = in.text("fleet", "RenderFleet to scale up when no slot is free", "");
  s.visitor_percent = static_cast<int>(
      in.integer("visitor-share",
                 "maximum percentage of all slots that people without an account may use together",
                 0, 100, kVisitorPercent));
  s.tls = wire::read_inner_tls(in, wire::Role::kApi);
  s.redis = wire::read_redis(in, s.tls);
  s.postgres = postgres::read_url(in, s.tls.plain_allowed);
}

void read_ports_and_origin(ConfigReader& in, Settings& s) {
  s.api_port = in.port("api-port",
                       "port of the REST API; listens on 127.0.0.1 only, behind the reverse proxy");
  s.admin = service::read_admin_options(in, "api");
  s.public_url = in.text("public-url", "origin that browsers use, such as https://host[:port]");
}

void read_directories(ConfigReader& in, Settings& s) {
  s.upload_dir = in.directory("upload-dir", "directory for uploads");
  s.volume_dir = in.directory("volume-dir", "directory of the volume store");
  s.cache_dir =
      in.directory("cache-dir", "directory of the cached images that the reverse proxy serves");
}

void read_mail(ConfigReader& in, Settings& s) {
  s.mail = in.text("mail", "where emails go: file:DIRECTORY or smtp://[user:password@]host:port");
  s.mail_from = in.text("mail-from", "sender of the emails: address or Name <address>");
}

void read_consent_version(ConfigReader& in, Settings& s) {
  s.consent_version =
      in.text("consent-version",
              "version of the privacy notice that users agree to; with a new one, all users are "
              "asked again",
              kPrivacyTemplate);
  if (!is_code_word(s.consent_version)) {
    in.mistake("--consent-version: must be 1 to 40 characters of a-z, 0-9, '_', '.' and '-'");
  }
}

void read_limits(ConfigReader& in, Settings& s) {
  s.data_sets.max_upload_bytes =
      in.integer("max-upload-mb", "maximum size of an upload, in MiB", 1, 1'000'000, 8192) << 20;
  s.data_sets.upload_life = std::chrono::seconds(
      in.integer("upload-expiry-s", "time after which an inactive upload expires, in seconds", 1,
                 30 * 86400, 86400));
  s.data_sets.reserve_bytes =
      in.integer("disk-reserve-mb", "disk space that uploads and exports leave free, in MiB", 0,
                 1'000'000, 1024)
      << 20;
  s.data_sets.limits.unprocessed = static_cast<int>(in.integer(
      "most-unprocessed",
      "maximum number of scans per account that are being uploaded or processed", 1, 100'000, 50));
  s.data_sets.limits.all = static_cast<int>(
      in.integer("most-data-sets", "maximum number of scans per account", 1, 1'000'000, 2000));
  s.export_total_bytes =
      in.integer("exports-mb", "maximum disk space for all exports together, in MiB", 1, 10'000'000,
                 20'480)
      << 20;
}

/// Returns the origin of an optional service.
std::string checked_origin(ConfigReader& in, const std::string& name, std::string url) {
  const bool origin = url.starts_with("http://") || url.starts_with("https://");
  if (!url.empty() && (!origin || url.ends_with('/'))) {
    in.mistake("--" + name + ": must be an origin without a path, such as http://host:port");
  }
  return url;
}

/// Returns the secret in the file, or an empty string without one.
std::string read_secret(ConfigReader& in, const std::string& name, const std::string& path) {
  std::string secret;
  if (path.empty()) return secret;
  std::ifstream file(path);
  if (!(file >> secret) || secret.size() < 32) {
    in.mistake("--" + name + ": the file does not exist or has fewer than 32 characters");
  }
  return secret;
}

void read_optional_services(ConfigReader& in, Settings& s) {
  const std::string analysis = in.text(
      "study-analysis-url",
      "origin of the service that analyses studies, such as http://127.0.0.1:8090; empty if "
      "it is not installed",
      "");
  s.study_analysis_url = checked_origin(in, "study-analysis-url", analysis);
  const std::string archives = in.text("archive-url",
                                       "origin of the PACS gateway, such as http://127.0.0.1:8096; "
                                       "empty if it is not installed",
                                       "");
  s.archive_url = checked_origin(in, "archive-url", archives);
  const std::string key =
      in.text("archive-key", "file with the secret that api and the PACS gateway share", "");
  s.archive_key = read_secret(in, "archive-key", key);
  if (!s.archive_url.empty() && s.archive_key.empty()) {
    in.mistake("--archive-key: the PACS gateway needs a secret");
  }
}

void read_secrets(ConfigReader& in, Settings& s) {
  const std::string token_file =
      in.text("sample-token", "file with the token that allows uploading the public sample", "");
  s.sample_token = read_secret(in, "sample-token", token_file);
  const std::string key_file = in.text(
      "factor-key", "file with the 64 hexadecimal digits of the key that encrypts TOTP secrets");
  if (auto key = SealingKey::read(key_file)) {
    s.factor_key = *std::move(key);
  } else if (!key_file.empty()) {
    in.mistake("--factor-key: " + key.error().message);
  }
}

void check_origin(ConfigReader& in, const std::string& public_url) {
  const bool origin = public_url.starts_with("http://") || public_url.starts_with("https://");
  if (!public_url.empty() && (!origin || public_url.ends_with('/'))) {
    in.mistake("--public-url: must be an origin without a path, such as https://host[:port]");
  }
}

}  // namespace

Settings read_settings(ConfigReader& in) {
  Settings s;
  read_databases(in, s);
  read_ports_and_origin(in, s);
  read_directories(in, s);
  read_mail(in, s);
  read_consent_version(in, s);
  read_limits(in, s);
  s.background = std::chrono::milliseconds(
      in.integer("background-ms", "maximum time between two runs of a background task, in ms", 50,
                 5000, 5000));
  read_optional_services(in, s);
  read_secrets(in, s);
  check_origin(in, s.public_url);
  return s;
}

}  // namespace diaphane::api
