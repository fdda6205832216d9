#pragma once

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "api/routing/request_router.h"

namespace diaphane::api {

/// Metrics of the REST API. Labels are operation IDs and statuses, so they are bounded and contain
/// no personal data. Thread-safe.
class RequestMetrics {
 public:
  explicit RequestMetrics(prometheus::Registry& registry);

  void measured(const Measured& request);
  void set_waiting(double requests) { waiting_.Set(requests); }
  void mails(int sent, int failed);
  void disposed(int files) { disposals_.Increment(files); }

 private:
  prometheus::Family<prometheus::Counter>& requests_;
  prometheus::Family<prometheus::Histogram>& seconds_;
  prometheus::Counter& upload_bytes_;
  prometheus::Counter& mails_sent_;
  prometheus::Counter& mails_failed_;
  prometheus::Counter& disposals_;
  prometheus::Gauge& waiting_;
};

}  // namespace diaphane::api
