#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/service/account_store.h"
#include "api/service/data_sets.h"
#include "api/service/placement.h"
#include "api/service/sharing_store.h"
#include "common/clock.h"

namespace diaphane::api {

/// What sharing and visits work with; all of it outlives them.
struct SharingParts {
  DataSets& data_sets;
  SharingStore& store;
  AccountStore& accounts;
  Placement& placement;
  const Clock& clock;
};

/// Sharing a data set with people, by links, with everybody; taking it back ends the sessions of
/// who lost it. Thread-safe.
class Sharing {
 public:
  struct Options {
    std::string public_url;  ///< origin, for links in mails
    int people = 50;         ///< of a data set, at most
    int links = 10;
    int invitations = 40;  ///< of an account in a day: each sends a mail
  };
  struct NewLink {
    DataSetLink link;
    std::string token;  ///< shown this once
  };
  struct Page {
    std::vector<DataSet> items;
    std::optional<Cursor> next;
  };

  Sharing(const SharingParts& parts, Options options)
      : parts_(parts), options_(std::move(options)) {}

  Outcome<std::vector<SharedPerson>> people(const Principal& who, const std::string& id);
  /// kInvalid for what is no address; the same answer whoever has an account. kTooMany.
  Outcome<void> share_with(const Principal& who, const std::string& id, const std::string& email,
                           bool may_save);
  Outcome<void> unshare(const Principal& who, const std::string& id, const std::string& person_id);

  Outcome<std::vector<DataSetLink>> links(const Principal& who, const std::string& id);
  /// The same key gives the same link and token again, in the browser that made it; kConflict when
  /// it was ended or in another. kTooMany, kIdempotencyKeyReused.
  Outcome<NewLink> make_link(const Principal& who, const std::string& id, std::chrono::hours life,
                             bool slices, const Once& once);
  Outcome<void> end_link(const Principal& who, const std::string& id, const std::string& link_id);

  /// kConflict ("anonymise first") without the owner's confirmed act; kNotReady. Without `slices`
  /// the sessions of those who had them end.
  Outcome<DataSet> publish(const Principal& who, const std::string& id, bool slices);
  Outcome<DataSet> make_private(const Principal& who, const std::string& id);
  /// Of what everybody sees, newest first; to nobody samples alone.
  Outcome<Page> gallery(const Principal& who, GalleryQuestion question);

  Outcome<std::string> public_name(const Principal& who);
  Outcome<void> set_public_name(const Principal& who, const std::string& name);

  /// Ends the sessions of everybody who may no longer look at the data set. What cannot be ended
  /// now is logged; nobody gets a new ticket for it.
  void end_lost_sessions(const std::string& id);
  /// Called after a mail was queued.
  void on_mail(std::function<void()> wake) { wake_mailer_ = std::move(wake); }

 private:
  /// Of those who see the data set only because it is public.
  void end_public_sessions(const std::string& id);

  SharingParts parts_;
  Options options_;
  std::function<void()> wake_mailer_ = [] {};
};

/// Looking without an account: at a sample, or by a link. Bounded in number and time. Thread-safe.
class Visits {
 public:
  struct Options {
    /// Visits that have not expired, whether somebody looks or not. How many hold a slot at once is
    /// bounded where they are placed: by the visitors' share (common/visitor_share.h).
    VisitLimits at_once{.most = 256, .by_address = 16, .by_link = 32};
    int by_address = 30;  ///< new ones in 15 minutes
    std::chrono::seconds sample_life = std::chrono::minutes(20);
    std::chrono::seconds link_life = std::chrono::hours(2);
  };
  struct Opened {
    std::string session_id;
    std::string stream_url;  ///< as of Sessions::Stream
    Time expires_at;
  };

  /// `first_scene` says what a new session on a data set shows first (PlaceRequest).
  Visits(const SharingParts& parts, Options options,
         std::function<std::string(const std::string& data_set_id)> first_scene)
      : parts_(parts), options_(options), first_scene_(std::move(first_scene)) {}

  /// What a link leads to. kNotFound: it was ended, has expired or never was.
  Outcome<SharingStore::Followed> follow(const std::string& token);
  /// `token` empty: the sample `data_set_id`. `key`: 64 hexadecimal digits of the visitor's own;
  /// the same key is the same session again, with a new ticket. kNotFound, kTooManyAttempts, kBusy,
  /// kNoWorker.
  Outcome<Opened> open(const std::string& token, const std::string& data_set_id,
                       const std::string& key, const std::string& address);
  /// Ends what has expired.
  void expire();

 private:
  SharingParts parts_;
  Options options_;
  const std::function<std::string(const std::string&)> first_scene_;
};

}  // namespace diaphane::api
