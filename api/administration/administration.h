#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/shared/audit.h"
#include "api/shared/cursor.h"
#include "api/shared/placement.h"
#include "api/shared/workers.h"

namespace diaphane::api {

/// An account as administrators see it: of its scans, only the number and the total size.
struct UserRecord {
  std::string id, email;
  Time created_at;
  std::optional<Time> used_at;  ///< last activity of a signed-in browser
  bool verified = false, disabled = false, administrator = false, researcher = false;
  bool archive_access = false;
  Quota storage;
  std::int64_t render_quota_ms = 0, render_used_ms = 0;  ///< device time this month
  int data_sets = 0;
};

struct UserChange {
  std::optional<std::int64_t> quota_bytes, render_quota_ms;
  std::optional<bool> disabled, researcher, archive_access;
};

/// A user with the administrator role.
struct Administrator {
  std::string email;
  bool second_factor = false;  ///< required to use the role
};

struct IngestQueue {
  int queued = 0, building = 0;
};

/// Every function returns kUnavailable if the database is unavailable. Each is one transaction,
/// which includes its entries in the audit log.
class AdministrationStore {
 public:
  virtual ~AdministrationStore() = default;
  /// Lists the accounts whose address contains `part` or whose ID it is, newest first.
  virtual Result<std::vector<UserRecord>> users(const std::string& part,
                                                const std::optional<Cursor>& after, int limit,
                                                Time now) = 0;
  virtual Result<std::optional<UserRecord>> user(const std::string& id, Time now) = 0;
  /// Changes the account. Disabling it ends all its web sessions and deletes its email tokens. A
  /// researcher who loses the role, or the account, has their open studies closed.
  /// Returns false if the account does not exist.
  virtual Result<bool> change(const std::string& administrator_id, const std::string& id,
                              const UserChange& change, Time now) = 0;
  /// Grants or revokes the role. Returns false if no verified account has this address.
  virtual Result<bool> set_administrator(const std::string& email_key, bool granted, Time now) = 0;
  virtual Result<std::vector<Administrator>> administrators() = 0;
  /// Writes an audit entry that records only that an administrator viewed data.
  virtual Result<void> note(const AuditEntry& entry, Time now) = 0;
  /// Lists the entries that match the filter, newest first.
  virtual Result<std::vector<AuditRecord>> audit(const AuditFilter& filter) = 0;
  virtual Result<IngestQueue> ingest_queue() = 0;
  /// Returns the IDs of the user's ready data sets, which other people may be viewing.
  virtual Result<std::vector<std::string>> ready_data_sets(const std::string& user_id) = 0;
};

/// The actions of administrators. The request router checks the permission first. Each access to
/// user data is recorded in the audit log before the data is returned. Thread-safe.
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
  /// Returns kNotFound, or kConflict if administrators try to disable their own account.
  Outcome<UserRecord> change(const Principal& who, const std::string& id, const UserChange& change);
  Outcome<AuditPage> audit(const Principal& who, AuditFilter filter);
  Outcome<Fleet> fleet();

 private:
  Outcome<UserRecord> find(const std::string& id);
  /// Ends all sessions of the account and of its data sets. Returns false if Redis is unavailable.
  bool end_pictures(const std::string& id);
  /// `subject_id` is empty if the entry concerns many accounts.
  Outcome<void> record_view(const Principal& who, std::string action, std::string subject,
                            std::string subject_id, std::vector<AuditDetail> details);

  AdministrationStore& store_;
  Placement& placement_;
  Workers& workers_;
  const Clock& clock_;
};

}  // namespace diaphane::api
