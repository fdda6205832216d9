#pragma once

#include <array>
#include <optional>
#include <string_view>

/// Who may what with a data set: the one table that every route asks.
namespace diaphane::api {

/// What somebody is to a data set. Who holds a link to it has kSharedView for as long as it holds.
enum class Role {
  kNobody,      ///< without an account
  kUnverified,  ///< with one whose address was never confirmed
  kOther,       ///< with one, and no more than that
  kSharedView,
  kSharedEdit,  ///< may save presets
  kOwner,       ///< of a sample: its operator
  kAdministrator,
};
inline constexpr std::array kRoles{Role::kNobody,       Role::kUnverified, Role::kOther,
                                   Role::kSharedView,   Role::kSharedEdit, Role::kOwner,
                                   Role::kAdministrator};

enum class Action {
  kFind,        ///< learn that it is there, its title and size
  kLook,        ///< open it, get pictures and presets of it
  kInvite,      ///< let others into one's own session by a live link
  kSavePreset,  ///< and change or delete it again
  kVote,        ///< for presets
  kReport,      ///< abuse
  kDescribe,    ///< title, description, body part, default preset; delete anybody's presets
  kShare,       ///< people and links, and seeing them
  kPublish,     ///< into the gallery and out of it
  kAnonymise,   ///< cut voxels away
  kDelete,      ///< with all that was made of it
  kTakeDown,    ///< and lift it again; delete anybody's presets; read reports
};
inline constexpr std::array kActions{Action::kFind,       Action::kLook,   Action::kInvite,
                                     Action::kSavePreset, Action::kVote,   Action::kReport,
                                     Action::kDescribe,   Action::kShare,  Action::kPublish,
                                     Action::kAnonymise,  Action::kDelete, Action::kTakeDown};

enum class Exposure {
  kPrivate,
  kPublic,
  kSample,     ///< public, belongs to nobody, and can be looked at without an account
  kTakenDown,  ///< by an administrator
};
inline constexpr std::array kExposures{Exposure::kPrivate, Exposure::kPublic, Exposure::kSample,
                                       Exposure::kTakenDown};

bool may(Role role, Action action, Exposure exposure);

/// What a signed-in person is: an administrator is also whatever anybody else would be.
struct Standing {
  Role role = Role::kNobody;
  bool administrator = false;
};
bool may(const Standing& standing, Action action, Exposure exposure);

/// "nobody", "unverified", "other", "shared-view", "shared-edit", "owner", "administrator".
std::string_view to_string(Role role);
std::optional<Role> role_of(std::string_view text);

}  // namespace diaphane::api
