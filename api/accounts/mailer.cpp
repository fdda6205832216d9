#include "api/accounts/mailer.h"

#include <algorithm>

#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr int kMailsAtOnce = 20;
constexpr int kMailAttempts = 12;  ///< over about 2.4 hours
constexpr auto kMailLease = std::chrono::minutes(2);

}  // namespace

std::chrono::seconds Mailer::pause_after(int failures) {
  const int doublings = std::clamp(failures - 1, 0, 20);
  return std::min<std::chrono::seconds>(std::chrono::seconds(5LL << doublings),
                                        std::chrono::hours(1));
}

Mailer::Sent Mailer::send_due() {
  Sent total;
  for (int i = 0; i < kMailsAtOnce; ++i) {
    const auto next = store_.claim_mail(clock_.wall(), kMailLease);
    if (!next || !*next) break;
    const MailStore::Queued& queued = **next;
    const auto sent = transport_.send(queued.mail);
    if (sent) {
      ++total.sent;
      (void)store_.mail_sent(queued.id);
      continue;
    }
    ++total.failed;
    const int failures = queued.attempts + 1;
    const bool hopeless = sent.error().code == ErrorCode::kInvalid || failures >= kMailAttempts;
    log::warning("failed to send an email", {{"mail", queued.id},
                                             {"failures", failures},
                                             {"given_up", hopeless},
                                             {"reason", sent.error().message}});
    if (hopeless) {
      (void)store_.mail_sent(queued.id);
    } else {
      (void)store_.mail_failed(queued.id, clock_.wall() + pause_after(failures));
    }
  }
  return total;
}

}  // namespace diaphane::api
