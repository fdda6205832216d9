#include "api/scans/access.h"

#include <initializer_list>
#include <utility>

namespace diaphane::api {
namespace {

constexpr std::array<std::pair<Role, std::string_view>, 7> kNames{{
    {Role::kNobody, "nobody"},
    {Role::kUnverified, "unverified"},
    {Role::kOther, "other"},
    {Role::kSharedView, "shared-view"},
    {Role::kSharedEdit, "shared-edit"},
    {Role::kOwner, "owner"},
    {Role::kAdministrator, "administrator"},
}};

constexpr unsigned bit(Action action) { return 1U << static_cast<unsigned>(action); }
constexpr unsigned all_of(std::initializer_list<Action> actions) {
  unsigned bits = 0;
  for (const Action action : actions) bits |= bit(action);
  return bits;
}

constexpr unsigned kSee = all_of({Action::kFind, Action::kLook});
/// Actions that every user may perform on public data sets.
constexpr unsigned kTakePart =
    kSee | all_of({Action::kInvite, Action::kSavePreset, Action::kVote, Action::kReport});
/// Actions that an owner may perform in any state.
constexpr unsigned kKeep =
    kSee | all_of({Action::kSavePreset, Action::kDescribe, Action::kSetTour, Action::kReadViews,
                   Action::kAnonymise, Action::kExport, Action::kDelete});
constexpr unsigned kJudge = kSee | bit(Action::kTakeDown);

unsigned allowed_when_private(Role role) {
  switch (role) {
    case Role::kSharedView:
      return kSee;
    case Role::kSharedEdit:
      return kSee | bit(Action::kSavePreset);
    case Role::kOwner:
      return kKeep | all_of({Action::kInvite, Action::kShare, Action::kPublish});
    case Role::kAdministrator:  // administrators must not see private data sets
    default:
      return 0;
  }
}

unsigned allowed_when_public(Role role) {
  switch (role) {
    case Role::kNobody:
    case Role::kUnverified:
      return 0;
    case Role::kOwner:
      return allowed_when_private(role) | bit(Action::kVote);
    case Role::kAdministrator:
      return kJudge;
    default:
      return kTakePart;
  }
}

unsigned allowed_of_a_sample(Role role) {
  switch (role) {
    case Role::kNobody:
    case Role::kUnverified:
      return kSee;
    case Role::kOwner:
      return kKeep;
    case Role::kAdministrator:  // a sample belongs to nobody
      return kJudge | bit(Action::kSetTour);
    default:
      return kTakePart;
  }
}

unsigned allowed_when_taken_down(Role role) {
  if (role == Role::kOwner) return kKeep;
  return role == Role::kAdministrator ? kJudge : 0;
}

unsigned allowed(Role role, Exposure exposure) {
  switch (exposure) {
    case Exposure::kPrivate:
      return allowed_when_private(role);
    case Exposure::kPublic:
      return allowed_when_public(role);
    case Exposure::kSample:
      return allowed_of_a_sample(role);
    case Exposure::kTakenDown:
      return allowed_when_taken_down(role);
  }
  return 0;
}

}  // namespace

bool may(Role role, Action action, Exposure exposure) {
  return (allowed(role, exposure) & bit(action)) != 0;
}

bool may(const DataSetRelation& relation, Action action, Exposure exposure) {
  return may(relation.role, action, exposure) ||
         (relation.administrator && may(Role::kAdministrator, action, exposure));
}

std::string_view to_string(Role role) {
  for (const auto& [value, name] : kNames) {
    if (value == role) return name;
  }
  return "nobody";
}

std::optional<Role> role_of(std::string_view text) {
  for (const auto& [value, name] : kNames) {
    if (name == text) return value;
  }
  return std::nullopt;
}

}  // namespace diaphane::api
