#pragma once

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "api/handlers/front.h"

namespace diaphane::api {

/// What the REST side counts. Labels are operationIds and statuses: bounded, and of nobody.
/// Thread-safe.
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
