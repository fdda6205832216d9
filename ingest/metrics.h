#pragma once

#include <prometheus/registry.h>

#include <memory>

#include "ingest/pipeline/worker.h"

namespace diaphane::ingest {

/// diaphane_ingest_jobs_total{result}, _build_seconds, _child_peak_bytes (the last child's),
/// _queue_depth, _waiting, _waits_total{for}, and _antivirus_total where uploads are checked.
class Metrics {
 public:
  explicit Metrics(prometheus::Registry& registry);
  ~Metrics();
  /// What a worker tells, counted. Lives no longer than this.
  WorkerEvents events();
  /// diaphane_ingest_antivirus_total{result}: there from here on.
  std::function<void(const std::string& result)> antivirus();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::ingest
