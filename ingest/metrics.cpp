#include "ingest/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>

namespace diaphane::ingest {

struct Metrics::Impl {
  prometheus::Registry& registry;
  prometheus::Family<prometheus::Counter>& jobs;
  prometheus::Histogram& seconds;
  prometheus::Gauge& peak;
  prometheus::Gauge& depth;
  prometheus::Gauge& waiting;
  prometheus::Gauge& interrupted;
  prometheus::Family<prometheus::Counter>& waits;
};

Metrics::Metrics(prometheus::Registry& registry)
    : impl_(new Impl{
          registry,
          prometheus::BuildCounter()
              .Name("diaphane_ingest_jobs_total")
              .Help("Processed uploads, by result: ready, or the reason for refusing them.")
              .Register(registry),
          prometheus::BuildHistogram()
              .Name("diaphane_ingest_build_seconds")
              .Help("Duration of the child process that reads an upload.")
              .Register(registry)
              .Add({}, prometheus::Histogram::BucketBoundaries{0.25, 0.5, 1, 2, 4, 8, 16, 32, 64,
                                                               128, 256}),
          prometheus::BuildGauge()
              .Name("diaphane_ingest_child_peak_bytes")
              .Help("Peak resident memory of the last child process.")
              .Register(registry)
              .Add({}),
          prometheus::BuildGauge()
              .Name("diaphane_ingest_queue_depth")
              .Help("Uploads that are waiting or being processed.")
              .Register(registry)
              .Add({}),
          prometheus::BuildGauge()
              .Name("diaphane_ingest_waiting")
              .Help("Uploads in the queue that wait for disk space, memory or a service, "
                    "or after an interruption.")
              .Register(registry)
              .Add({}),
          prometheus::BuildGauge()
              .Name("diaphane_ingest_interrupted")
              .Help("Jobs during which ingestd exited more than once, and which may be "
                    "the cause.")
              .Register(registry)
              .Add({}),
          prometheus::BuildCounter()
              .Name("diaphane_ingest_waits_total")
              .Help("Postponed attempts, by missing resource: room, memory or service.")
              .Register(registry)}) {
  for (const auto reason : {WaitReason::kRoom, WaitReason::kMemory, WaitReason::kService}) {
    impl_->waits.Add({{"for", to_string(reason)}});
  }
  impl_->jobs.Add({{"result", "ready"}});  // exports 0 before the first job
}
Metrics::~Metrics() = default;

WorkerEvents Metrics::events() {
  WorkerEvents events;
  Impl* self = impl_.get();
  events.done = [self](const std::string& code) { self->jobs.Add({{"result", code}}).Increment(); };
  events.built = [self](double seconds, std::uint64_t peak) {
    self->seconds.Observe(seconds);
    self->peak.Set(static_cast<double>(peak));
  };
  events.queue = [self](const QueueState& queue) {
    self->depth.Set(static_cast<double>(queue.jobs));
    self->waiting.Set(static_cast<double>(queue.waiting));
    self->interrupted.Set(static_cast<double>(queue.suspect));
  };
  events.waits = [self](WaitReason reason) {
    self->waits.Add({{"for", to_string(reason)}}).Increment();
  };
  return events;
}

std::function<void(const std::string&)> Metrics::antivirus() {
  auto& family = prometheus::BuildCounter()
                     .Name("diaphane_ingest_antivirus_total")
                     .Help("Uploads by result of the virus scan: clean, infected or unchecked.")
                     .Register(impl_->registry);
  for (const char* result : {"clean", "infected", "unchecked"}) family.Add({{"result", result}});
  return [&family](const std::string& result) { family.Add({{"result", result}}).Increment(); };
}

}  // namespace diaphane::ingest
