#include "api/admin_command.h"

#include <cstdio>

#include "api/postgres/administration_repository.h"
#include "api/service/password.h"
#include "common/clock.h"

namespace diaphane::api {
namespace {

constexpr int kExitUnavailable = 69;  ///< sysexits.h

int failed(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return error.code == ErrorCode::kUnavailable ? kExitUnavailable : 1;
}

}  // namespace

int run_admin(ConfigReader& in) {
  const std::string url = in.text("postgres", "libpq URL");
  const auto& words = in.words();
  const std::string what = words.size() > 1 ? words[1] : "";
  const bool list = what == "list" && words.size() == 2;
  const bool change = (what == "grant" || what == "revoke") && words.size() == 3;
  if (!list && !change) in.mistake("admin grant EMAIL | revoke EMAIL | list");
  if (auto done = in.finish("diaphane-api admin grant|revoke EMAIL, admin list: administrators")) {
    return *done;
  }
  Database database(url, 1);
  AdministrationRepository store(database);
  if (list) {
    const auto emails = store.administrators();
    if (!emails) return failed(emails.error());
    for (const std::string& email : *emails) std::printf("%s\n", email.c_str());
    return 0;
  }
  const auto done =
      store.set_administrator(email_key(words[2]), what == "grant", SystemClock().wall());
  if (!done) return failed(done.error());
  if (!*done) {
    std::fprintf(stderr, "There is no account with this address, or it is not confirmed yet.\n");
    return 1;
  }
  std::printf("%s is %s administrator.\n", words[2].c_str(),
              what == "grant" ? "an" : "no longer an");
  return 0;
}

}  // namespace diaphane::api
