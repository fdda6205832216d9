#include "api/scans/access.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace diaphane::api {
namespace {

/// The whole table, repeated by hand. Each column is an action, in the order of `kActions`: find,
/// look, invite, save preset, vote, report, describe, set tour, share, read views, publish,
/// anonymise, export, delete, take down.
const std::map<std::pair<Exposure, Role>, std::string> kTable{
    {{Exposure::kPrivate, Role::kNobody}, "---------------"},
    {{Exposure::kPrivate, Role::kUnverified}, "---------------"},
    {{Exposure::kPrivate, Role::kOther}, "---------------"},
    {{Exposure::kPrivate, Role::kSharedView}, "FL-------------"},
    {{Exposure::kPrivate, Role::kSharedEdit}, "FL-S-----------"},
    {{Exposure::kPrivate, Role::kOwner}, "FLIS--DTHWPAEX-"},
    {{Exposure::kPrivate, Role::kAdministrator}, "---------------"},
    {{Exposure::kPublic, Role::kNobody}, "---------------"},
    {{Exposure::kPublic, Role::kUnverified}, "---------------"},
    {{Exposure::kPublic, Role::kOther}, "FLISVR---------"},
    {{Exposure::kPublic, Role::kSharedView}, "FLISVR---------"},
    {{Exposure::kPublic, Role::kSharedEdit}, "FLISVR---------"},
    {{Exposure::kPublic, Role::kOwner}, "FLISV-DTHWPAEX-"},
    {{Exposure::kPublic, Role::kAdministrator}, "FL------------T"},
    {{Exposure::kSample, Role::kNobody}, "FL-------------"},
    {{Exposure::kSample, Role::kUnverified}, "FL-------------"},
    {{Exposure::kSample, Role::kOther}, "FLISVR---------"},
    {{Exposure::kSample, Role::kSharedView}, "FLISVR---------"},
    {{Exposure::kSample, Role::kSharedEdit}, "FLISVR---------"},
    {{Exposure::kSample, Role::kOwner}, "FL-S--DT-W-AEX-"},
    {{Exposure::kSample, Role::kAdministrator}, "FL-----T------T"},
    {{Exposure::kTakenDown, Role::kNobody}, "---------------"},
    {{Exposure::kTakenDown, Role::kUnverified}, "---------------"},
    {{Exposure::kTakenDown, Role::kOther}, "---------------"},
    {{Exposure::kTakenDown, Role::kSharedView}, "---------------"},
    {{Exposure::kTakenDown, Role::kSharedEdit}, "---------------"},
    {{Exposure::kTakenDown, Role::kOwner}, "FL-S--DT-W-AEX-"},
    {{Exposure::kTakenDown, Role::kAdministrator}, "FL------------T"},
};

TEST(Access, MatchesTheExpectedMatrix) {
  ASSERT_EQ(kTable.size(), kRoles.size() * kExposures.size());
  for (const Exposure exposure : kExposures) {
    for (const Role role : kRoles) {
      const std::string& row = kTable.at({exposure, role});
      ASSERT_EQ(row.size(), kActions.size());
      for (std::size_t i = 0; i < kActions.size(); ++i) {
        EXPECT_EQ(may(role, kActions[i], exposure), row[i] != '-')
            << to_string(role) << ", exposure " << static_cast<int>(exposure) << ", action " << i;
      }
    }
  }
}

TEST(Access, EveryActionRequiresFind) {
  for (const Exposure exposure : kExposures) {
    for (const Role role : kRoles) {
      if (may(role, Action::kFind, exposure)) continue;
      for (const Action action : kActions) EXPECT_FALSE(may(role, action, exposure));
    }
  }
}

TEST(Access, AdministratorRightsAddToThoseOfTheDataSetRole) {
  for (const Exposure exposure : kExposures) {
    for (const Role role : kRoles) {
      for (const Action action : kActions) {
        EXPECT_EQ(may(DataSetRelation{role, true}, action, exposure),
                  may(role, action, exposure) || may(Role::kAdministrator, action, exposure));
        EXPECT_EQ(may(DataSetRelation{role, false}, action, exposure), may(role, action, exposure));
      }
    }
  }
}

TEST(Access, RoleNamesRoundTrip) {
  for (const Role role : kRoles) EXPECT_EQ(role_of(to_string(role)), role);
  EXPECT_FALSE(role_of("god"));
}

}  // namespace
}  // namespace diaphane::api
