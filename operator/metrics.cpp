#include "operator/metrics.h"

namespace diaphane::fleet {

Metrics::Metrics(prometheus::Registry& registry)
    : seconds_(prometheus::BuildHistogram()
                   .Name("diaphane_operator_plan_seconds")
                   .Help("Observing and planning.")
                   .Register(registry)
                   .Add({}, prometheus::Histogram::BucketBoundaries{0.001, 0.003, 0.01, 0.03, 0.1,
                                                                    0.3, 1, 3})),
      actions_(prometheus::BuildCounter()
                   .Name("diaphane_operator_actions_total")
                   .Help("Actions carried out, by kind and outcome.")
                   .Register(registry)),
      leads_(prometheus::BuildGauge()
                 .Name("diaphane_operator_leader")
                 .Help("1: this operator holds the lease.")
                 .Register(registry)
                 .Add({})),
      watches_(
          prometheus::BuildGauge()
              .Name("diaphane_operator_watch_count")
              .Help("Lists, watches, events, failures, expired and silent watches since the start.")
              .Register(registry)) {}

void Metrics::watch(const std::string& kind, const kube::Reflector::Counts& counts) {
  const auto set = [&](const char* what, std::uint64_t value) {
    watches_.Add({{"kind", kind}, {"what", what}}).Set(static_cast<double>(value));
  };
  set("lists", counts.lists);
  set("watches", counts.watches);
  set("events", counts.events);
  set("failures", counts.failures);
  set("expired", counts.expired);
  set("silent", counts.silent);
}

}  // namespace diaphane::fleet
