#pragma once

#include <string>

#include "api/service/account_store.h"
#include "api/service/data_sets.h"
#include "api/service/idempotency.h"
#include "api/service/placement.h"
#include "api/service/problem.h"
#include "common/clock.h"

namespace diaphane::api {

/// Joining somebody's session by a link that its owner can end. Who has the link sees the pictures
/// and who else is there, and nothing else of the owner; no account is needed. Thread-safe.
class LiveLinks {
 public:
  struct Joined {
    std::string participant;  ///< id of the guest, the same for the same key
    std::string stream_url;   ///< as of Sessions::Stream
  };

  struct Options {
    /// By people who join, in 15 minutes: enough for a class behind one address whose streams break
    /// now and then.
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

  /// The token of a new link: shown this once, kept as a hash; the same key gives the same one
  /// again, or kConflict once it was ended. kNotFound (the session), kTooMany.
  Outcome<std::string> make(const Principal& who, const std::string& session_id, const Once& once);
  /// Every link of the session; who came by them is sent away.
  Outcome<void> end(const Principal& who, const std::string& session_id);
  /// `key`: 64 hexadecimal digits of the guest's own, by which he is the same person when he comes
  /// back. kNotFound: the link was ended, has expired or never was; kTooManyAttempts; kBusy: the
  /// session has no slot and the visitors' share is taken; else as Sessions::ticket.
  Outcome<Joined> join(const std::string& token, const std::string& key, const std::string& name,
                       const std::string& address);

 private:
  /// The data set of the session; kNotFound unless it is this person's.
  Outcome<std::string> check_owner(const Principal& who, const std::string& session_id);

  DataSets& data_sets_;
  Placement& placement_;
  LinkStore& links_;
  AccountStore& accounts_;
  const Clock& clock_;
  const Options options_;
};

}  // namespace diaphane::api
