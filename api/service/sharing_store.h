#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/service/data_set_store.h"

namespace diaphane::api {

/// Somebody a data set is shared with, as its owner typed it. Whether there is an account is not
/// told.
struct SharedPerson {
  std::string id;  ///< of the sharing, not of an account
  std::string email_key;
  bool may_save = false;  ///< presets; else view only
  Time created_at;
};

/// Of a link: never its token, which is kept as a hash.
struct DataSetLink {
  std::string id;
  Time created_at;
  Time expires_at;
  bool slices = false;  ///< who comes by it may have exact slices
};

struct GalleryQuestion {
  std::string words;      ///< beginnings of words of title and description; empty: all
  std::string body_part;  ///< one of kBodyParts, or empty
  std::string modality;   ///< one of kModalities, or empty
  bool samples_only = false;
  std::optional<Cursor> after;  ///< by time of publication
  int limit = 0;
};

/// A session of somebody without an account.
struct Visit {
  std::string session_id;
  std::string data_set_id;
  std::string link_id;  ///< empty: of a sample
  Time expires_at;
  std::string address_hash = {};  ///< where the visitor asked from
};

/// Visits at once: in all, from one address and by one link.
struct VisitLimits {
  int most = 0, by_address = 0, by_link = 0;
};

/// Whom a data set is shared with, and how. Every function: kUnavailable when the database is away.
/// Each is one transaction. Whether somebody may is asked before (access.h).
class SharingStore {
 public:
  virtual ~SharingStore() = default;

  virtual Result<std::vector<SharedPerson>> people(const std::string& data_set_id) = 0;
  /// A new person, or another right for one that is there. The mail is queued for a new one.
  /// kTooMany when there are `most` already. False: it was there.
  virtual Result<bool> share_with(const std::string& data_set_id, const SharedPerson& person,
                                  int most, const Mail& mail) = 0;
  /// kNotFound.
  virtual Result<void> unshare(const std::string& data_set_id, const std::string& person_id) = 0;

  virtual Result<std::vector<DataSetLink>> links(const std::string& data_set_id, Time now) = 0;
  /// `owner_id`: whose key it is. What the same key made before, if that link is still there and
  /// of this token; kConflict when it is not. kTooMany.
  virtual Result<std::variant<DataSetLink, KeyReused>> make_link(
      const std::string& data_set_id, const DataSetLink& link, const std::string& token_hash,
      int most, const std::string& owner_id, const std::optional<IdempotencyKey>& key) = 0;
  /// With its visits. kNotFound.
  virtual Result<void> end_link(const std::string& data_set_id, const std::string& link_id) = 0;
  struct Followed {
    DataSetLink link;
    DataSet data_set;  ///< ready; the role is kSharedView
  };
  /// kNotFound: no such link, expired, or its data set is shown to nobody.
  virtual Result<Followed> follow(const std::string& token_hash, Time now) = 0;

  /// `slices`: whoever looks may have exact slices; also of one that is public already. False: it
  /// is not anonymised, not built, or taken down.
  virtual Result<bool> publish(const std::string& data_set_id, bool slices, Time now) = 0;
  virtual Result<void> make_private(const std::string& data_set_id, Time now) = 0;
  virtual Result<std::vector<DataSet>> gallery(const Viewer& viewer,
                                               const GalleryQuestion& question) = 0;

  virtual Result<std::string> public_name(const std::string& user_id) = 0;
  virtual Result<void> set_public_name(const std::string& user_id, const std::string& name) = 0;

  /// Notes the visit; again, it stays as it was, and what it was is the answer. kTooMany when as
  /// many as `limits` allow have not expired; `field` says which: "address", "link" or empty.
  virtual Result<Visit> note_visit(const Visit& visit, const VisitLimits& limits, Time now) = 0;
  /// kNotFound when there is none, or it has expired.
  virtual Result<Visit> find_visit(const std::string& session_id, Time now) = 0;
  /// The sessions that are to be ended, and then forgotten.
  virtual Result<std::vector<std::string>> expired_visits(Time now) = 0;
  virtual Result<void> forget_visit(const std::string& session_id) = 0;
  virtual Result<void> expire_links(Time now) = 0;
};

}  // namespace diaphane::api
