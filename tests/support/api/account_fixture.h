#pragma once

#include <gtest/gtest.h>

#include <string>

#include "api/accounts/accounts.h"
#include "api/accounts/attempts.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "tests/support/api/fake_account_store.h"
#include "tests/support/api/fake_placement.h"
#include "tests/support/api/fake_second_factor_store.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {

/// A verified account whose user is signed in.
class AccountFixture : public testing::Test {
 protected:
  AccountFixture() {
    who.user_id = new_id();
    who.email = "Anna@example.org";
    who.session_id = new_id();
    attempts.accounts[email_key(who.email)] = {who.user_id, who.email,
                                               hasher.hash(password).value(), true, false};
  }
  /// The number of attempts that count against a limit.
  int counted(std::string_view what, std::string_view whose) const {
    const std::string key = attempt_key(what, whose);
    return static_cast<int>(std::count_if(attempts.attempts.begin(), attempts.attempts.end(),
                                          [&](const auto& one) { return one.first == key; }));
  }

  const std::string password = "a long and quiet password";
  Principal who;
  ManualClock clock;
  Signals signals;
  FakePasswordHasher hasher;
  FakeAccountStore attempts;
  FakeSecondFactorStore factors;
  FakePlacement placement;
  const SealingKey key = SealingKey::of_hex(std::string(64, '1')).value();
  CodeCheck codes{factors, attempts, key, clock, signals, {}};
  Accounts accounts{
      attempts, hasher, codes, key, clock, signals, {.public_url = "https://see.example"}};
};

}  // namespace diaphane::api
