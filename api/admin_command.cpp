#include "api/admin_command.h"

#include <algorithm>
#include <cstdio>

#include "api/accounts/account_mails.h"
#include "api/accounts/password.h"
#include "api/accounts/second_factor_repository.h"
#include "api/administration/administration_repository.h"
#include "common/clock.h"
#include "common/postgres/address.h"
#include "common/wire/inner_tls.h"

namespace diaphane::api {
namespace {

constexpr int kExitUnavailable = 69;  ///< sysexits.h

int failed(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return error.code == ErrorCode::kUnavailable ? kExitUnavailable : 1;
}

int show_administrators(AdministrationRepository& store) {
  const auto all = store.administrators();
  if (!all) return failed(all.error());
  for (const Administrator& one : *all) {
    std::printf("%s%s\n", one.email.c_str(),
                one.second_factor ? "" : " (two-factor authentication not set up)");
  }
  return 0;
}

int set_administrator(AdministrationRepository& store, const std::string& email, bool granted) {
  const auto done = store.set_administrator(email_key(email), granted, SystemClock().wall());
  if (!done) return failed(done.error());
  if (!*done) {
    std::fprintf(stderr, "No confirmed account has this email address.\n");
    return 1;
  }
  std::printf("%s is %s administrator.\n", email.c_str(), granted ? "an" : "no longer an");
  const auto all = store.administrators();
  if (!all) return failed(all.error());
  const bool waits = std::any_of(all->begin(), all->end(), [&](const Administrator& one) {
    return email_key(one.email) == email_key(email) && !one.second_factor;
  });
  if (waits) {
    std::printf(
        "The role takes effect once this user turns on two-factor authentication on their "
        "account page.\n");
  }
  return 0;
}

int reset_second_factor(Database& database, const std::string& email) {
  SecondFactorRepository store(database);
  const std::string key = email_key(email);
  const auto done = store.take_off(key, mails::second_factor_taken_off(key), SystemClock().wall());
  if (!done) return failed(done.error());
  if (!*done) {
    std::fprintf(stderr, "No account with two-factor authentication has this email address.\n");
    return 1;
  }
  std::printf(
      "%s can sign in with the password alone until they turn on two-factor authentication "
      "again.\n",
      email.c_str());
  return 0;
}

}  // namespace

int run_admin(ConfigReader& in) {
  const std::string url = postgres::read_url(in, wire::read_plain_allowed(in));
  const auto& arguments = in.words();
  const std::string what = arguments.size() > 1 ? arguments[1] : "";
  const bool list = what == "list" && arguments.size() == 2;
  const bool old_name = what == "forget-factor";  // an old name that this release still accepts
  const bool reset = (what == "reset-2fa" || old_name) && arguments.size() == 3;
  const bool change = (what == "grant" || what == "revoke") && arguments.size() == 3;
  if (!list && !change && !reset) {
    in.mistake("usage: diaphane-api admin grant EMAIL | revoke EMAIL | list | reset-2fa EMAIL");
  }
  if (auto done = in.finish(
          "diaphane-api admin: manage administrators\n\n"
          "  admin grant EMAIL      make a user an administrator\n"
          "  admin revoke EMAIL     take the administrator role from a user\n"
          "  admin list             list the administrators\n"
          "  admin reset-2fa EMAIL  turn off two-factor authentication for a user who lost their\n"
          "                         device and their recovery codes")) {
    return *done;
  }
  if (old_name) {
    std::fprintf(stderr,
                 "'forget-factor' is deprecated and will be removed in the next release. "
                 "Use 'reset-2fa'.\n");
  }
  Database database(url, 1);
  AdministrationRepository store(database);
  if (list) return show_administrators(store);
  if (reset) return reset_second_factor(database, arguments[2]);
  return set_administrator(store, arguments[2], what == "grant");
}

}  // namespace diaphane::api
