#pragma once

#include <prometheus/registry.h>

#include <memory>

#include "ingest/pipeline/worker.h"

namespace diaphane::ingest {

/// The metrics diaphane_ingest_jobs_total{result}, _build_seconds, _child_peak_bytes (of the last
/// child), _queue_depth, _waiting, _interrupted, _waits_total{for}, and _antivirus_total where
/// uploads are checked.
class Metrics {
 public:
  explicit Metrics(prometheus::Registry& registry);
  ~Metrics();
  /// Returns callbacks that count a worker's events. They must not outlive this object.
  WorkerEvents events();
  /// Registers diaphane_ingest_antivirus_total{result} and returns the callback that counts it.
  std::function<void(const std::string& result)> antivirus();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::ingest
