#pragma once

#include "api/accounts/mailer.h"
#include "api/http/request_metrics.h"
#include "api/privacy/disposer.h"
#include "api/services.h"
#include "api/shared/periodic.h"

namespace diaphane::api {

/// The work that no request waits for: emails, preset thumbnails, deletions, exports and expiry. A
/// signal wakes a task when a service has work for it.
class BackgroundTasks {
 public:
  /// All arguments must outlive this object.
  BackgroundTasks(const Backends& on, Services& services, MailTransport& transport,
                  RequestMetrics& metrics);

 private:
  void delete_disposed();
  std::chrono::milliseconds at_most(std::chrono::milliseconds period) const;

  const Settings& settings_;
  const Clock& clock_;
  Stores& stores_;
  Services& services_;
  RequestMetrics& metrics_;
  Mailer mailer_;
  Disposer disposer_;
  Periodic send_mails_;
  Periodic make_pictures_;
  Periodic dispose_;
  Periodic end_visits_;
  Periodic end_studies_;
  Periodic end_browsers_;
  Periodic tidy_;
  Periodic count_render_time_;
  Periodic make_exports_;
};

}  // namespace diaphane::api
