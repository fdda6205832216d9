#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/accounts/account_store.h"
#include "api/scans/data_sets.h"
#include "api/shared/placement.h"
#include "api/shared/signals.h"
#include "api/sharing/sharing_store.h"
#include "common/clock.h"

namespace diaphane::api {

/// The dependencies of Sharing and Visits. They must outlive both.
struct SharingParts {
  DataSets& data_sets;
  SharingStore& store;
  AccountStore& accounts;
  Placement& placement;
  const Clock& clock;
  const Signals& signals;
};

/// Shares a data set with people, with links or with everyone. Withdrawing access ends the affected
/// sessions. Thread-safe.
class Sharing {
 public:
  struct Options {
    std::string public_url;  ///< origin of links in emails
    int people = 50;         ///< maximum per data set
    int links = 10;
    int invitations = 40;  ///< maximum per account and day, because each sends an email
  };
  struct NewLink {
    DataSetLink link;
    std::string token;  ///< shown only once
  };
  struct Page {
    std::vector<DataSet> items;
    std::optional<Cursor> next;
  };

  Sharing(const SharingParts& parts, Options options)
      : parts_(parts), options_(std::move(options)) {}

  Outcome<std::vector<SharedPerson>> people(const Principal& who, const std::string& id);
  /// Shares with an address. Gives the same answer whether or not it has an account. Returns
  /// kInvalid, kTooMany or kTooManyAttempts.
  Outcome<void> share_with(const Principal& who, const std::string& id, const std::string& email,
                           bool may_save, const Permissions& allowed);
  /// Changes what a person may do. Ends their sessions if they lose slices or downloads.
  Outcome<void> change_person(const Principal& who, const std::string& id,
                              const std::string& person_id, const PersonChange& change);
  Outcome<void> unshare(const Principal& who, const std::string& id, const std::string& person_id);

  Outcome<std::vector<DataSetLink>> links(const Principal& who, const std::string& id);
  /// Creates a link. The same key returns the same link and token in the browser that created it,
  /// and kConflict in another browser or once the link is disabled. Returns kTooMany or
  /// kIdempotencyKeyReused.
  Outcome<NewLink> make_link(const Principal& who, const std::string& id, std::chrono::hours life,
                             const Permissions& allowed, const IdempotencyScope& once);
  Outcome<void> end_link(const Principal& who, const std::string& id, const std::string& link_id);

  /// Returns kNotAnonymised unless the owner has anonymised the scan, or kNotReady. If slices or
  /// downloads are withdrawn, ends the sessions of users who had them because the data set was
  /// public.
  Outcome<DataSet> publish(const Principal& who, const std::string& id, const Permissions& allowed);
  Outcome<DataSet> make_private(const Principal& who, const std::string& id);
  /// Lists public data sets, newest first. Without an account, only samples.
  Outcome<Page> gallery(const Principal& who, GalleryQuery query);

  Outcome<std::string> public_name(const Principal& who);
  Outcome<void> set_public_name(const Principal& who, const std::string& name);

  /// Ends the sessions of everyone who lost access to the data set. Failures are logged; no new
  /// tickets are issued in any case.
  void end_lost_sessions(const std::string& id);

 private:
  /// Ends the sessions of a user on a data set, so that new ones get the user's new permissions.
  void end_sessions_of(const std::string& id, const std::string& user_id);
  /// Ends the sessions of users who lost access to the data set, or had one of these permissions
  /// only because the data set was public.
  void end_public_sessions(const std::string& id, const Permissions& withdrawn);
  /// Ends the sessions on a data set, except those of visitors, and of users who can still see it
  /// and for whom `keeps` returns true. Ends none if the database is unavailable.
  void end_sessions_unless(const std::string& id,
                           const std::function<bool(const DataSet& visible)>& keeps);

  SharingParts parts_;
  Options options_;
};

/// Visits without an account: to a sample, or with a link. Limits their number and time.
/// Thread-safe.
class Visits {
 public:
  struct Options {
    /// Maximum number of unexpired visits, active or not. The placement limits how many hold a slot
    /// at the same time (common/visitor_share.h).
    VisitLimits at_once{.most = 256, .by_address = 16, .by_link = 32};
    int by_address = 30;  ///< new visits within 15 minutes
    std::chrono::seconds sample_life = std::chrono::minutes(20);
    std::chrono::seconds link_life = std::chrono::hours(2);
  };
  struct Opened {
    std::string session_id;
    std::string stream_url;  ///< as in Sessions::Stream
    Time expires_at;
  };

  /// `first_scene` returns the initial scene of a new session on a data set (PlaceRequest).
  Visits(const SharingParts& parts, Options options,
         std::function<std::string(const std::string& data_set_id)> first_scene)
      : parts_(parts), options_(options), first_scene_(std::move(first_scene)) {}

  /// Returns the data set of a link, or kNotFound if the link is unknown, expired or disabled.
  Outcome<SharingStore::Followed> follow(const std::string& token);
  /// Opens a visit with a link, or to the sample `data_set_id` if `token` is empty. `key` is 64
  /// hexadecimal digits that the visitor's browser keeps. The same key returns the same session
  /// with a new ticket. Returns kNotFound, kTooManyAttempts, kBusy or kNoWorker.
  Outcome<Opened> open(const std::string& token, const std::string& data_set_id,
                       const std::string& key, const Client& client);
  /// Ends expired visits and deletes expired links.
  void expire();

 private:
  SharingParts parts_;
  Options options_;
  const std::function<std::string(const std::string&)> first_scene_;
};

}  // namespace diaphane::api
