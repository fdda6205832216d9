#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/scans/data_set_store.h"

namespace diaphane::api {

/// A person with access to a data set. The address is the one that the owner entered, so that it
/// does not reveal whether an account exists.
struct SharedPerson {
  std::string id;  ///< ID of the permission, not of an account
  std::string email_key;
  bool may_save = false;  ///< may save presets; otherwise view only
  Permissions allowed{true, true};
  Time created_at;
};

/// Changes to what a person may do. Absent members stay unchanged.
struct PersonChange {
  std::optional<bool> may_save, slices, downloads;
};

/// A link, without its token, of which only a hash is stored.
struct DataSetLink {
  std::string id;
  Time created_at;
  Time expires_at;
  Permissions allowed = {};
};

struct GalleryQuery {
  std::string words;      ///< prefixes of words in title and description; empty matches all
  std::string body_part;  ///< one of kBodyParts, or empty
  std::string modality;   ///< one of kModalities, or empty
  bool samples_only = false;
  std::optional<Cursor> after;  ///< sorted by time of publication
  int limit = 0;
};

/// A session of a visitor without an account.
struct Visit {
  std::string session_id;
  std::string data_set_id;
  std::string link_id;  ///< empty for a sample
  Time expires_at;
  std::string address_hash = {};  ///< hash of the visitor's address
};

/// Maximum number of simultaneous visits: in total, per address and per link.
struct VisitLimits {
  int most = 0, by_address = 0, by_link = 0;
};

/// Stores permissions and links. Every function returns kUnavailable if the database is
/// unavailable. Each is one transaction, which includes its entry in the audit log. The caller
/// checks permissions first (access.h).
class SharingStore {
 public:
  virtual ~SharingStore() = default;

  virtual Result<std::vector<SharedPerson>> people(const std::string& data_set_id) = 0;
  struct Shared {
    bool added = false;            ///< the person is new, so an email was queued
    std::string narrowed_user_id;  ///< the account that lost slices or downloads, or empty
  };
  /// Adds a person or changes the permission of an existing one. Returns kTooMany if there are
  /// already `most`.
  virtual Result<Shared> share_with(const std::string& data_set_id, const SharedPerson& person,
                                    int most, const Mail& mail) = 0;
  /// Changes what a person may do. Returns kNotFound if the data set is not shared with them.
  virtual Result<Shared> change_person(const std::string& data_set_id, const std::string& person_id,
                                       const PersonChange& change, Time now) = 0;
  /// Withdraws a permission. Returns the account that had it, or nothing if the invitation was
  /// still open. Returns kNotFound if the permission does not exist.
  virtual Result<std::string> unshare(const std::string& data_set_id, const std::string& person_id,
                                      Time now) = 0;

  virtual Result<std::vector<DataSetLink>> links(const std::string& data_set_id, Time now) = 0;
  /// Creates a link. If the user's `key` has created a link before, returns that link, or kConflict
  /// if it no longer exists or has another token. Returns kTooMany if there are already `most`
  /// links.
  virtual Result<std::variant<DataSetLink, KeyReused>> make_link(
      const std::string& data_set_id, const DataSetLink& link, const std::string& token_hash,
      int most, const std::string& owner_id, const std::optional<IdempotencyKey>& key) = 0;
  /// Deletes a link and its visits. Returns kNotFound if it does not exist.
  virtual Result<void> end_link(const std::string& data_set_id, const std::string& link_id,
                                Time now) = 0;
  struct Followed {
    DataSetLink link;
    DataSet data_set;  ///< ready; the role is kSharedView
  };
  /// Returns kNotFound if the link is unknown or expired, or its data set is not visible.
  virtual Result<Followed> follow(const std::string& token_hash, Time now) = 0;

  /// Makes the data set public, or changes what is allowed for an already public one. Returns false
  /// if the data set is not anonymised, not ready, or taken down.
  virtual Result<bool> publish(const std::string& data_set_id, const Permissions& allowed,
                               Time now) = 0;
  virtual Result<void> make_private(const std::string& data_set_id, Time now) = 0;
  virtual Result<std::vector<DataSet>> gallery(const Viewer& viewer, const GalleryQuery& query) = 0;

  virtual Result<std::string> public_name(const std::string& user_id) = 0;
  virtual Result<void> set_public_name(const std::string& user_id, const std::string& name) = 0;

  /// Records the visit. A repeated call returns the existing one unchanged. Returns kTooMany if a
  /// limit is reached. The error's `field` names it: "address", "link" or empty for the total.
  virtual Result<Visit> note_visit(const Visit& visit, const VisitLimits& limits, Time now) = 0;
  /// Returns the visit, or kNotFound if it does not exist or has expired.
  virtual Result<Visit> find_visit(const std::string& session_id, Time now) = 0;
  /// Returns the session IDs of expired visits, which the caller must end and then forget.
  virtual Result<std::vector<std::string>> expired_visits(Time now) = 0;
  virtual Result<void> forget_visit(const std::string& session_id) = 0;
  virtual Result<void> expire_links(Time now) = 0;
};

}  // namespace diaphane::api
