#include "common/postgres/address.h"

#include <libpq-fe.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <vector>

#include "common/try.h"
#include "common/wire/inner_tls.h"

namespace diaphane::postgres {
namespace {

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};
using Options = std::unique_ptr<PQconninfoOption, FreeOptions>;

/// Sets PGSERVICE while it exists, because libpq reads a service file only for its default
/// settings.
class ServiceOfDefaults {
 public:
  explicit ServiceOfDefaults(const std::string& name) {
    if (const char* before = std::getenv(kName)) before_ = before;
    if (!name.empty()) setenv(kName, name.c_str(), 1);
  }
  ~ServiceOfDefaults() {
    if (before_) {
      setenv(kName, before_->c_str(), 1);
    } else {
      unsetenv(kName);
    }
  }
  ServiceOfDefaults(const ServiceOfDefaults&) = delete;
  ServiceOfDefaults& operator=(const ServiceOfDefaults&) = delete;

 private:
  static constexpr const char* kName = "PGSERVICE";
  std::optional<std::string> before_;
};

std::vector<std::string> listed(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

/// Returns the hosts that libpq may try. An address takes precedence over its host name.
std::vector<std::string> hosts_of(const std::map<std::string, std::string>& settings) {
  const auto value = [&](const char* keyword) {
    const auto found = settings.find(keyword);
    return found == settings.end() ? std::string() : found->second;
  };
  std::vector<std::string> names = listed(value("host"));
  const std::string addresses = value("hostaddr");
  if (addresses.empty()) return names;
  std::vector<std::string> hosts = listed(addresses);
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    if (hosts[i].empty() && i < names.size()) hosts[i] = names[i];
  }
  return hosts;
}

bool is_socket(const std::string& host) {
  return host.empty() || host.front() == '/' || host.front() == '@';
}

}  // namespace

Result<std::map<std::string, std::string>> resolved(const std::string& url) {
  const Options parsed(PQconninfoParse(url.c_str(), nullptr));
  if (!parsed) {
    // libpq's own message may quote the password.
    return fail(ErrorCode::kInvalid,
                "not a valid connection URI (postgresql://user@host/name) or keyword/value string "
                "(host=... dbname=...)");
  }
  std::map<std::string, std::string> settings;
  for (const PQconninfoOption* option = parsed.get(); option->keyword; ++option) {
    if (option->val) settings[option->keyword] = option->val;
  }
  const ServiceOfDefaults service(settings.contains("service") ? settings["service"] : "");
  const Options defaults(PQconndefaults());
  if (!defaults) {
    return fail(ErrorCode::kInvalid,
                "the service file (PGSERVICEFILE) does not define this service");
  }
  for (const PQconninfoOption* option = defaults.get(); option->keyword; ++option) {
    if (option->val) settings.try_emplace(option->keyword, option->val);
  }
  return settings;
}

Result<void> may_be_used(const std::string& url, bool plain_allowed) {
  auto settings = resolved(url);
  DIAPHANE_TRY(settings);
  const std::string mode = (*settings)["sslmode"];
  if (plain_allowed || mode == "verify-full" || mode == "verify-ca") return {};
  for (const std::string& host : hosts_of(*settings)) {
    if (is_socket(host) || wire::is_this_machine(host)) continue;
    return fail(ErrorCode::kInvalid,
                host +
                    " is a remote host, and the connection would not use verified TLS. Add "
                    "sslmode=verify-full and sslrootcert=FILE, or set --inner-plain 1 if the "
                    "network itself is private.");
  }
  return {};
}

std::string read_url(ConfigReader& in, bool plain_allowed) {
  std::string url =
      in.text("postgres", "libpq connection URI; a remote host requires sslmode=verify-full");
  if (url.empty()) return url;
  if (const auto usable = may_be_used(url, plain_allowed); !usable) {
    in.mistake("--postgres: " + usable.error().message);
  }
  return url;
}

}  // namespace diaphane::postgres
