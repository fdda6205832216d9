#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/service/accounts.h"
#include "api/service/audit.h"
#include "api/service/cursor.h"
#include "api/service/placement.h"
#include "api/service/workers.h"

namespace diaphane::api {

/// An account, as an administrator sees it: nothing of its scans but their number and size.
struct UserRecord {
  std::string id, email;
  Time created_at;
  std::optional<Time> used_at;  ///< the last use of a browser that is signed in
  bool verified = false, disabled = false, administrator = false;
  Quota storage;
  std::int64_t render_quota_ms = 0, render_used_ms = 0;  ///< of a device, this month
  int data_sets = 0;
};

struct UserChange {
  std::optional<std::int64_t> quota_bytes, render_quota_ms;
  std::optional<bool> disabled;
};

/// Somebody who has the administrator's role.
struct Administrator {
  std::string email;
  bool second_factor = false;  ///< without one the role opens nothing
};

struct IngestQueue {
  int queued = 0, building = 0;
};

/// Every function: kUnavailable when the database is away. Each is one transaction, its entries in
/// the audit log included.
class AdministrationStore {
 public:
  virtual ~AdministrationStore() = default;
  /// Newest first; those whose address holds `part`, or whose id it is.
  virtual Result<std::vector<UserRecord>> users(const std::string& part,
                                                const std::optional<Cursor>& after, int limit,
                                                Time now) = 0;
  virtual Result<std::optional<UserRecord>> user(const std::string& id, Time now) = 0;
  /// Disabling ends every browser's session and forgets tokens. False: no such account.
  virtual Result<bool> change(const std::string& administrator_id, const std::string& id,
                              const UserChange& change, Time now) = 0;
  /// By a command on the machine. False: no such verified account.
  virtual Result<bool> set_administrator(const std::string& email_key, bool given, Time now) = 0;
  virtual Result<std::vector<Administrator>> administrators() = 0;
  /// An entry of the audit log about nothing but itself: that an administrator looked.
  virtual Result<void> note(const AuditEntry& entry, Time now) = 0;
  /// Newest first.
  virtual Result<std::vector<AuditRecord>> audit(const AuditFilter& filter) = 0;
  virtual Result<IngestQueue> ingest_queue() = 0;
  /// Those that others may be looking at.
  virtual Result<std::vector<std::string>> ready_data_sets(const std::string& user_id) = 0;
};

/// What administrators see and do. Who may is checked before (handlers/front.h). What is looked at
/// of people is in the audit log before it is given out. Thread-safe.
class Administration {
 public:
  struct Users {
    std::vector<UserRecord> items;
    std::optional<Cursor> next;
  };
  struct AuditPage {
    std::vector<AuditRecord> items;
    std::optional<std::int64_t> next;
  };
  struct Fleet {
    std::vector<WorkerInfo> workers;
    IngestQueue ingest;
  };

  Administration(AdministrationStore& store, Placement& placement, Workers& workers,
                 const Clock& clock)
      : store_(store), placement_(placement), workers_(workers), clock_(clock) {}

  Outcome<Users> users(const Principal& who, const std::string& part, std::optional<Cursor> after,
                       int limit);
  Outcome<UserRecord> user(const Principal& who, const std::string& id);
  /// kNotFound; kConflict: oneself cannot be disabled.
  Outcome<UserRecord> change(const Principal& who, const std::string& id, const UserChange& change);
  Outcome<AuditPage> audit(const Principal& who, AuditFilter filter);
  Outcome<Fleet> fleet();

 private:
  Outcome<UserRecord> find(const std::string& id);
  /// Every picture of the account, and everybody's of its data sets. False: not all, Redis is away.
  bool end_pictures(const std::string& id);
  /// `subject_id` may be empty: of many.
  Outcome<void> note_look(const Principal& who, std::string action, std::string subject,
                          std::string subject_id, std::vector<AuditDetail> details);

  AdministrationStore& store_;
  Placement& placement_;
  Workers& workers_;
  const Clock& clock_;
};

}  // namespace diaphane::api
