#pragma once

#include <string>

#include "api/accounts/account_store.h"
#include "api/scans/data_sets.h"
#include "api/shared/idempotency.h"
#include "api/shared/placement.h"
#include "api/shared/problem.h"
#include "common/clock.h"

namespace diaphane::api {

/// Lets guests join a session with a link that its owner can disable. Guests need no account. They
/// see the images and the other participants, but no other data of the owner. Thread-safe.
class LiveLinks {
 public:
  struct Joined {
    std::string participant;  ///< ID of the guest, the same for the same key
    std::string stream_url;   ///< as in Sessions::Stream
  };

  struct Options {
    /// Limits on joins within 15 minutes. They suffice for a school class behind one address whose
    /// streams break occasionally.
    int by_address = 240;
    int by_link = 960;
  };

  LiveLinks(DataSets& data_sets, Placement& placement, LinkStore& links, AccountStore& accounts,
            const Clock& clock, Options options)
      : data_sets_(data_sets),
        placement_(placement),
        links_(links),
        accounts_(accounts),
        clock_(clock),
        options_(options) {}

  /// Returns the token of a new link, which is shown only once and stored as a hash. With `slices`,
  /// guests with this link may get all slices inside the clip; a host without slices cannot allow
  /// that (kInvalid). The same key returns the same token, kConflict once the link is disabled, or
  /// kIdempotencyKeyReused if `slices` differs. Returns kNotFound (session) or kTooMany.
  Outcome<std::string> make(const Principal& who, const std::string& session_id, bool slices,
                            const IdempotencyScope& once);
  /// Disables all links of the session and disconnects everyone who joined with them.
  Outcome<void> end(const Principal& who, const std::string& session_id);
  /// Joins the session of a link. `key` is 64 hexadecimal digits that the guest's browser keeps, so
  /// that a returning guest is the same participant. Returns kNotFound if the link is unknown,
  /// expired or disabled, kTooManyAttempts, kBusy if the session has no slot and the visitors'
  /// share is in use, or the other errors of Sessions::ticket.
  Outcome<Joined> join(const std::string& token, const std::string& key, const std::string& name,
                       const Client& client);

 private:
  /// Returns the data sets of a session that its owner may still view, or kNotFound.
  Outcome<std::vector<DataSet>> find_shown(const SessionInfo& session);
  /// Returns the session, or kNotFound if the session belongs to someone else.
  Outcome<SessionInfo> check_owner(const Principal& who, const std::string& session_id);

  DataSets& data_sets_;
  Placement& placement_;
  LinkStore& links_;
  AccountStore& accounts_;
  const Clock& clock_;
  const Options options_;
};

}  // namespace diaphane::api
