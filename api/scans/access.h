#pragma once

#include <array>
#include <optional>
#include <string_view>

/// The permissions on a data set. Every route checks this single table.
namespace diaphane::api {

/// The role of a user for a data set. A visitor with a link has kSharedView while the link is
/// valid.
enum class Role {
  kNobody,      ///< without an account
  kUnverified,  ///< with an account whose email address was never confirmed
  kOther,       ///< with an account, but without any other relation to the data set
  kSharedView,
  kSharedEdit,  ///< can save presets
  kOwner,       ///< for a sample: its operator
  kAdministrator,
};
inline constexpr std::array kRoles{Role::kNobody,       Role::kUnverified, Role::kOther,
                                   Role::kSharedView,   Role::kSharedEdit, Role::kOwner,
                                   Role::kAdministrator};

enum class Action {
  kFind,        ///< see that it exists, its title and its size
  kLook,        ///< open it and get its images and presets
  kInvite,      ///< let others join your own session with a live link
  kSavePreset,  ///< and change or delete your own presets
  kVote,        ///< vote for presets
  kReport,      ///< report abuse
  kDescribe,    ///< set title, description, body part, labels and default preset; delete any preset
  kShare,       ///< list and change people and links
  kReadViews,   ///< see who viewed it
  kPublish,     ///< add it to the gallery or remove it
  kAnonymise,   ///< remove voxels
  kDelete,      ///< with everything derived from it
  kTakeDown,    ///< and restore it; delete any preset; read reports
};
inline constexpr std::array kActions{
    Action::kFind,      Action::kLook,     Action::kInvite,  Action::kSavePreset, Action::kVote,
    Action::kReport,    Action::kDescribe, Action::kShare,   Action::kReadViews,  Action::kPublish,
    Action::kAnonymise, Action::kDelete,   Action::kTakeDown};

enum class Exposure {
  kPrivate,
  kPublic,
  kSample,     ///< public, belongs to nobody and can be viewed without an account
  kTakenDown,  ///< hidden by an administrator
};
inline constexpr std::array kExposures{Exposure::kPrivate, Exposure::kPublic, Exposure::kSample,
                                       Exposure::kTakenDown};

bool may(Role role, Action action, Exposure exposure);

/// The role of a signed-in user. An administrator also has the role that they would have otherwise.
struct DataSetRelation {
  Role role = Role::kNobody;
  bool administrator = false;
};
bool may(const DataSetRelation& relation, Action action, Exposure exposure);

/// "nobody", "unverified", "other", "shared-view", "shared-edit", "owner", "administrator".
std::string_view to_string(Role role);
std::optional<Role> role_of(std::string_view text);

}  // namespace diaphane::api
