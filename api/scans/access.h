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
  kSavePreset,  ///< save presets and marks, and change or delete your own
  kVote,        ///< vote for presets
  kReport,      ///< report abuse
  kDescribe,    ///< set metadata, labels and default preset; share marks; delete any preset
  kSetTour,     ///< choose the views of "Show me around"
  kShare,       ///< list and change people and links
  kReadViews,   ///< see who viewed it
  kPublish,     ///< add it to the gallery or remove it
  kAnonymise,   ///< remove voxels
  kExport,      ///< take it along as a file for other programs
  kDelete,      ///< delete it with everything derived from it
  kTakeDown,    ///< take down and restore it; delete any preset; read reports
};
inline constexpr std::array kActions{
    Action::kFind,    Action::kLook,      Action::kInvite,  Action::kSavePreset, Action::kVote,
    Action::kReport,  Action::kDescribe,  Action::kSetTour, Action::kShare,      Action::kReadViews,
    Action::kPublish, Action::kAnonymise, Action::kExport,  Action::kDelete,     Action::kTakeDown};

enum class Exposure {
  kPrivate,
  kPublic,
  kSample,     ///< public, belongs to nobody and can be viewed without an account
  kTakenDown,  ///< hidden by an administrator
};
inline constexpr std::array kExposures{Exposure::kPrivate, Exposure::kPublic, Exposure::kSample,
                                       Exposure::kTakenDown};

bool may(Role role, Action action, Exposure exposure);

/// The role of a signed-in user. Administrators also keep the role that they have as a user.
struct DataSetRelation {
  Role role = Role::kNobody;
  bool administrator = false;
};
bool may(const DataSetRelation& relation, Action action, Exposure exposure);

/// Returns the text of a role in the API and the database, such as "shared-view".
std::string_view to_string(Role role);
std::optional<Role> role_of(std::string_view text);

}  // namespace diaphane::api
