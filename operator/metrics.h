#pragma once

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <string>

#include "operator/kube/informer.h"

namespace diaphane::fleet {

/// Metrics of the operator itself. Fleets are reported in their statuses.
class Metrics {
 public:
  explicit Metrics(prometheus::Registry& registry);
  void planned(double seconds) { seconds_.Observe(seconds); }
  void action(const char* name, bool done) {
    actions_.Add({{"action", name}, {"outcome", done ? "done" : "failed"}}).Increment();
  }
  void leads(bool leads) { leads_.Set(leads ? 1 : 0); }
  void watch(const std::string& kind, const kube::Reflector::Counts& counts);

 private:
  prometheus::Histogram& seconds_;
  prometheus::Family<prometheus::Counter>& actions_;
  prometheus::Gauge& leads_;
  prometheus::Family<prometheus::Gauge>& watches_;
};

}  // namespace diaphane::fleet
