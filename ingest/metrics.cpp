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
    : impl_(new Impl{registry,
                     prometheus::BuildCounter()
                         .Name("diaphane_ingest_jobs_total")
                         .Help("Uploads dealt with, by result: ready, or why they were refused.")
                         .Register(registry),
                     prometheus::BuildHistogram()
                         .Name("diaphane_ingest_build_seconds")
                         .Help("Time of the child that reads an upload.")
                         .Register(registry)
                         .Add({}, prometheus::Histogram::BucketBoundaries{0.25, 0.5, 1, 2, 4, 8, 16,
                                                                          32, 64, 128, 256}),
                     prometheus::BuildGauge()
                         .Name("diaphane_ingest_child_peak_bytes")
                         .Help("Largest resident memory of the last child.")
                         .Register(registry)
                         .Add({}),
                     prometheus::BuildGauge()
                         .Name("diaphane_ingest_queue_depth")
                         .Help("Uploads that wait or are being read.")
                         .Register(registry)
                         .Add({}),
                     prometheus::BuildGauge()
                         .Name("diaphane_ingest_waiting")
                         .Help("Of these, uploads that wait for room, memory, a service, or after "
                               "an interruption.")
                         .Register(registry)
                         .Add({}),
                     prometheus::BuildGauge()
                         .Name("diaphane_ingest_interrupted")
                         .Help("Jobs during which ingestd ended more than once. They may be the "
                               "reason why it ends.")
                         .Register(registry)
                         .Add({}),
                     prometheus::BuildCounter()
                         .Name("diaphane_ingest_waits_total")
                         .Help("Attempts put off, by what was missing: room, memory or service.")
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
                     .Help("Uploads by what clamd said: clean, infected, or unchecked.")
                     .Register(impl_->registry);
  for (const char* result : {"clean", "infected", "unchecked"}) family.Add({{"result", result}});
  return [&family](const std::string& result) { family.Add({{"result", result}}).Increment(); };
}

}  // namespace diaphane::ingest
