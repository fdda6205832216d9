#include "operator/metrics.h"

namespace diaphane::fleet {

Metrics::Metrics(prometheus::Registry& registry)
    : seconds_(prometheus::BuildHistogram()
                   .Name("diaphane_operator_plan_seconds")
                   .Help("Seconds spent observing and planning, per round.")
                   .Register(registry)
                   .Add({}, prometheus::Histogram::BucketBoundaries{0.001, 0.003, 0.01, 0.03, 0.1,
                                                                    0.3, 1, 3})),
      actions_(prometheus::BuildCounter()
                   .Name("diaphane_operator_actions_total")
                   .Help("Actions that the operator executed, by kind and outcome.")
                   .Register(registry)),
      leads_(prometheus::BuildGauge()
                 .Name("diaphane_operator_leader")
                 .Help("1 if this operator is the leader, else 0.")
                 .Register(registry)
                 .Add({})),
      watches_(prometheus::BuildGauge()
                   .Name("diaphane_operator_watch_count")
                   .Help("List and watch calls, events, failures, and expired or stalled watches "
                         "since start-up.")
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
