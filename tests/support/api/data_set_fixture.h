#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "api/scans/data_sets.h"
#include "common/ids.h"
#include "tests/support/api/fake_account_store.h"
#include "tests/support/api/fake_data_set_store.h"
#include "tests/support/api/fake_placement.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {

/// A private scan that is ready, users with every role for it, and the fakes that the services on
/// data sets share.
class DataSetFixture : public testing::Test {
 protected:
  DataSetFixture() {
    scan().id = id;
    scan().state = DataSetState::kReady;
    for (const Role role : kRoles) {
      data_set_store.roles[{std::string(to_string(role)), id}] = role;
    }
    data_set_store.roles.erase({"administrator", id});
  }

  DataSet& scan() { return data_set_store.data_sets[id]; }
  void expose(Exposure exposure) {
    scan().is_public = exposure == Exposure::kPublic || exposure == Exposure::kSample;
    scan().is_sample = exposure == Exposure::kSample;
    scan().taken_down = exposure == Exposure::kTakenDown;
  }
  /// Adds another ready, private scan of the same owner.
  std::string add_scan() {
    const std::string other = new_id();
    data_set_store.data_sets[other].id = other;
    data_set_store.data_sets[other].state = DataSetState::kReady;
    data_set_store.roles[{"owner", other}] = Role::kOwner;
    return other;
  }

  /// A user whose ID is the name of their role.
  static Principal as(Role role) {
    Principal who;
    if (role == Role::kNobody) return who;
    who.user_id = to_string(role);
    who.email = who.user_id + "@example.org";
    who.session_id = "browser of " + who.user_id;
    who.administrator = role == Role::kAdministrator;
    return who;
  }
  /// Sends the request as every role for the scan in every exposure, and expects it to be refused
  /// where the table of access.h refuses `action`, and to succeed everywhere else.
  void expect_permission(Action action, const std::function<Refusal(const Principal&)>& request) {
    for (const Exposure exposure : kExposures) {
      for (const Role role : kRoles) {
        expose(exposure);
        const bool administrator = role == Role::kAdministrator;
        const DataSetRelation relation{administrator ? Role::kOther : role, administrator};
        Refusal expected;
        if (!may(relation, action, exposure)) expected = ProblemKind::kForbidden;
        if (!may(relation, Action::kFind, exposure)) expected = ProblemKind::kNotFound;
        EXPECT_EQ(request(as(role)), expected)
            << to_string(role) << ", exposure " << static_cast<int>(exposure);
      }
    }
    expose(Exposure::kPrivate);
  }

  const Principal owner = as(Role::kOwner);
  const Principal shared = as(Role::kSharedView);
  const Principal stranger = as(Role::kOther);
  const Principal administrator = as(Role::kAdministrator);
  const std::string id = new_id();
  ManualClock clock;
  Signals signals;
  FakeDataSetStore data_set_store;
  FakePlacement placement;
  FakeAccountStore accounts;
  std::int64_t free_bytes = std::int64_t{1} << 40;
  DataSets data_sets{data_set_store, placement, clock, signals, {}, [this] { return free_bytes; }};
};

}  // namespace diaphane::api
