#pragma once

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>

#include <cstddef>
#include <string>

#include "api/stream/close_code.h"

namespace diaphane::api::stream {

enum class Direction { kToWorker, kToViewer };

/// Metrics of the gateway. Thread-safe.
class GatewayMetrics {
 public:
  explicit GatewayMetrics(prometheus::Registry& registry);

  void connection_opened() { connections_.Increment(); }
  void connection_closed() { connections_.Decrement(); }
  void stream_attached() { streams_.Increment(); }
  void stream_detached() { streams_.Decrement(); }
  void message(Direction direction, std::size_t bytes);
  /// Counts a refusal before a stream starts. Reasons: "busy", "handshake", "origin", "ticket",
  /// "session", "unavailable", "internal", "too_many".
  void refused(const std::string& reason);
  void closed(CloseCode code);
  void worker_lost() { workers_lost_.Increment(); }
  void slow_viewer() { slow_viewers_.Increment(); }

 private:
  prometheus::Gauge& connections_;
  prometheus::Gauge& streams_;
  prometheus::Family<prometheus::Counter>& messages_;
  prometheus::Family<prometheus::Counter>& bytes_;
  prometheus::Counter& messages_to_worker_;
  prometheus::Counter& messages_to_viewer_;
  prometheus::Counter& bytes_to_worker_;
  prometheus::Counter& bytes_to_viewer_;
  prometheus::Family<prometheus::Counter>& refusals_;
  prometheus::Family<prometheus::Counter>& closes_;
  prometheus::Counter& workers_lost_;
  prometheus::Counter& slow_viewers_;
};

}  // namespace diaphane::api::stream
