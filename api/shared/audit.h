#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "api/shared/time.h"
#include "common/result.h"

/// The audit log (migrations/0004) of who did what and when. Each entry is written in the
/// transaction of the change that it records (note_in_audit_log in
/// api/shared/audit_repository.h).
namespace diaphane::api {

/// Retention time of an entry. The database refuses to delete a younger one.
inline constexpr std::chrono::hours kAuditLife{24 * 366};

enum class AuditActor { kPerson, kAdministrator, kMachine };
std::string_view to_string(AuditActor actor);

/// The name and value of a detail. A text value is a code word: 1 to 40 characters of [a-z0-9_.-],
/// so that user input and scan data do not fit.
using AuditDetail = std::pair<std::string, std::variant<std::int64_t, std::string>>;

/// Returns whether the text is a code word.
bool is_code_word(std::string_view text);

struct AuditEntry {
  AuditActor actor = AuditActor::kPerson;
  std::string actor_id;  ///< the account's ID; empty for the system or a deleted account
  std::string action;    ///< "account.password-changed"
  std::string subject;   ///< "account", "data_set"
  std::string subject_id;
  std::vector<AuditDetail> details;
};

/// Returns the details as a JSON object. Throws std::logic_error for a detail that might contain
/// personal data, because that is a bug.
std::string details_as_json(const std::vector<AuditDetail>& details);

struct AuditRecord {
  std::int64_t id = 0;  ///< increases with time
  Time happened_at;
  std::string actor;  ///< "person", "administrator", "machine"
  std::string actor_id, action, subject, subject_id;
  std::string details;  ///< a JSON object
  /// Current addresses of these accounts, if they still exist.
  std::string actor_email, subject_email;
};

struct AuditFilter {
  std::string account_id;  ///< matches the actor or the subject; empty matches any
  std::string action;      ///< prefix of the action; empty matches any
  std::optional<Time> from, until;
  std::optional<std::int64_t> before_id;  ///< position of the next page
  int limit = 50;
};

}  // namespace diaphane::api
