#pragma once

#include <chrono>

#include "api/accounts/account_store.h"
#include "common/clock.h"

namespace diaphane::api {

/// Sends one email. Implemented in api/mail.
class MailTransport {
 public:
  virtual ~MailTransport() = default;
  /// Returns kUnavailable if a retry makes sense and kInvalid if the recipient is rejected
  /// permanently.
  virtual Result<void> send(const Mail& mail) = 0;
};

/// Sends the due emails of the queue. Each email is sent at least once, until it is given up.
class Mailer {
 public:
  Mailer(MailStore& store, MailTransport& transport, const Clock& clock)
      : store_(store), transport_(transport), clock_(clock) {}
  struct Sent {
    int sent = 0, failed = 0;
  };
  Sent send_due();
  /// Returns the delay after the n-th failure: 5 s, doubled each time, at most one hour.
  static std::chrono::seconds pause_after(int failures);

 private:
  MailStore& store_;
  MailTransport& transport_;
  const Clock& clock_;
};

}  // namespace diaphane::api
