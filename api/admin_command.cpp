#include "api/admin_command.h"

#include <algorithm>
#include <cstdio>

#include "api/postgres/administration_repository.h"
#include "api/postgres/second_factor_repository.h"
#include "api/service/account_mails.h"
#include "api/service/password.h"
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
    std::printf("%s%s\n", one.email.c_str(), one.second_factor ? "" : " (no second factor yet)");
  }
  return 0;
}

int set_administrator(AdministrationRepository& store, const std::string& email, bool given) {
  const auto done = store.set_administrator(email_key(email), given, SystemClock().wall());
  if (!done) return failed(done.error());
  if (!*done) {
    std::fprintf(stderr, "There is no account with this address, or it is not confirmed yet.\n");
    return 1;
  }
  std::printf("%s is %s administrator.\n", email.c_str(), given ? "an" : "no longer an");
  const auto all = store.administrators();
  if (!all) return failed(all.error());
  const bool waits = std::any_of(all->begin(), all->end(), [&](const Administrator& one) {
    return email_key(one.email) == email_key(email) && !one.second_factor;
  });
  if (waits) {
    std::printf(
        "The role opens nothing before a second factor is set up: sign in, then Account, Second "
        "factor.\n");
  }
  return 0;
}

int forget_factor(Database& database, const std::string& email) {
  SecondFactorRepository store(database);
  const std::string key = email_key(email);
  const auto done = store.take_off(key, mails::second_factor_taken_off(key), SystemClock().wall());
  if (!done) return failed(done.error());
  if (!*done) {
    std::fprintf(stderr, "There is no account with this address, or it has no second factor.\n");
    return 1;
  }
  std::printf("%s signs in with the password alone until a second factor is set up again.\n",
              email.c_str());
  return 0;
}

}  // namespace

int run_admin(ConfigReader& in) {
  const std::string url = postgres::read_url(in, wire::read_plain_allowed(in));
  const auto& words = in.words();
  const std::string what = words.size() > 1 ? words[1] : "";
  const bool list = what == "list" && words.size() == 2;
  const bool forget = what == "forget-factor" && words.size() == 3;
  const bool change = (what == "grant" || what == "revoke") && words.size() == 3;
  if (!list && !change && !forget) {
    in.mistake("admin grant EMAIL | revoke EMAIL | list | forget-factor EMAIL");
  }
  if (auto done = in.finish(
          "diaphane-api admin grant|revoke EMAIL, admin list: administrators\n"
          "diaphane-api admin forget-factor EMAIL: for who has lost device and recovery codes")) {
    return *done;
  }
  Database database(url, 1);
  AdministrationRepository store(database);
  if (list) return show_administrators(store);
  if (forget) return forget_factor(database, words[2]);
  return set_administrator(store, words[2], what == "grant");
}

}  // namespace diaphane::api
