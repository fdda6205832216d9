#pragma once

#include <atomic>
#include <nlohmann/json.hpp>
#include <string>

#include "api/accounts/accounts.h"
#include "api/shared/audit.h"
#include "api/shared/problem.h"
#include "api/shared/secrets.h"
#include "common/clock.h"

namespace diaphane::api {

/// Calls the PACS gateway (pacs/ at the top of the repository). Implemented by gateway_client.
class ArchiveGateway {
 public:
  struct Answer {
    int status = 0;
    std::string body;
  };
  virtual ~ArchiveGateway() = default;
  virtual bool installed() const = 0;
  /// Sends a JSON document. Returns kUnavailable if the gateway does not answer.
  virtual Result<Answer> send(const std::string& path, const std::string& body) = 0;
};

/// Every function returns kUnavailable if the database is unavailable.
class ArchiveStore {
 public:
  virtual ~ArchiveStore() = default;
  virtual Result<void> note(const AuditEntry& entry, Time now) = 0;
  /// Stores the hash of a token that can only upload, and the entry, in one transaction.
  virtual Result<void> begin_fetch(const std::string& user_id, const std::string& token_hash,
                                   Time now, Time expires_at, const AuditEntry& entry) = 0;
};

/// Searches the hospital's archives and fetches series from them. The request router checks the
/// access. What an archive says about patients is passed through: it is never stored or logged.
/// Every request is recorded in the audit log before its result is returned, with studies and
/// series as keyed hashes. Thread-safe.
class Archives {
 public:
  using Json = nlohmann::ordered_json;
  static constexpr int kMostSearches =
      8;  ///< at the same time, because each may take half a minute
  static constexpr std::chrono::hours kFetchLife{1};

  struct Search {
    std::string patient_name, patient_id, accession, modality;
    std::string from, until;  ///< YYYY-MM-DD, or empty
  };
  struct Series {
    std::string study, series, title;
  };

  Archives(ArchiveGateway& gateway, ArchiveStore& store, const SealingKey& key, const Clock& clock)
      : gateway_(gateway), store_(store), key_(key), clock_(clock) {}

  /// Returns no archives if the gateway is not installed.
  Outcome<Json> list();
  /// Returns kNotFound unless there is an archive with this name.
  Outcome<void> require(const std::string& archive);
  Outcome<Json> search(const Principal& who, const std::string& archive, const Search& search);
  Outcome<Json> series(const Principal& who, const std::string& archive, const std::string& study);
  /// Starts a fetch, which becomes an upload of this account.
  Outcome<Json> fetch(const Principal& who, const std::string& archive, const Series& series);
  Outcome<Json> status(const Principal& who, const std::string& archive, const std::string& id);
  Outcome<void> cancel(const Principal& who, const std::string& archive, const std::string& id);
  /// Records that the gateway received a study from outside. `via` is "stow" or "dimse".
  Outcome<void> receive(const Principal& who, const std::string& via, const std::string& study);

 private:
  Outcome<Json> ask(const std::string& path, const Json& body);
  Outcome<void> record(const Principal& who, std::string action, std::vector<AuditDetail> details);
  Outcome<Json> ask_and_record(const Principal& who, const std::string& path, const Json& body,
                               const std::string& action, std::vector<AuditDetail> details);
  std::string hash(const std::string& uid) const { return key_.mac("archive " + uid); }

  ArchiveGateway& gateway_;
  ArchiveStore& store_;
  const SealingKey& key_;
  const Clock& clock_;
  std::atomic<int> searches_{0};
};

}  // namespace diaphane::api
