#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "api/service/account_store.h"
#include "common/result.h"

/// The audit log (migrations/0004): who did what, when. Entries are written in the transaction of
/// what they tell of (api/postgres/audit_repository.h, note_in_audit_log).
namespace diaphane::api {

/// How long an entry is kept. The database refuses to forget a younger one.
inline constexpr std::chrono::hours kAuditLife{24 * 366};

enum class AuditActor { kPerson, kAdministrator, kMachine };
std::string_view to_string(AuditActor actor);

/// A number, or a code word of at most 40 of [a-z0-9_.-]: nothing that a person typed or a scan
/// holds fits in.
using AuditDetail = std::pair<std::string, std::variant<std::int64_t, std::string>>;

struct AuditEntry {
  AuditActor actor = AuditActor::kPerson;
  std::string actor_id;  ///< empty: of the machine, or deleted since
  std::string action;    ///< "account.password-changed"
  std::string subject;   ///< "account", "data_set"
  std::string subject_id;
  std::vector<AuditDetail> details;
};

/// The details as a JSON object. Throws std::logic_error for a detail that could say something of a
/// person: a defect.
std::string details_as_json(const std::vector<AuditDetail>& details);

struct AuditRecord {
  std::int64_t id = 0;  ///< rises with time
  Time happened_at;
  std::string actor;  ///< "person", "administrator", "machine"
  std::string actor_id, action, subject, subject_id;
  std::string details;                     ///< a JSON object
  std::string actor_email, subject_email;  ///< of those accounts, while there are such
};

struct AuditFilter {
  std::string account_id;  ///< as actor or subject; empty: any
  std::string action;      ///< that it begins with; empty: any
  std::optional<Time> from, until;
  std::optional<std::int64_t> before_id;  ///< the next page
  int limit = 50;
};

}  // namespace diaphane::api
