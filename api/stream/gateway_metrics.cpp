#include "api/stream/gateway_metrics.h"

namespace diaphane::api::stream {
namespace {

prometheus::Gauge& gauge(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildGauge().Name(name).Help(help).Register(registry).Add({});
}

prometheus::Family<prometheus::Counter>& counters(prometheus::Registry& registry, const char* name,
                                                  const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

}  // namespace

GatewayMetrics::GatewayMetrics(prometheus::Registry& registry)
    : connections_(gauge(registry, "diaphane_stream_connections",
                         "Open connections on the stream port, including handshakes.")),
      streams_(gauge(registry, "diaphane_stream_attached", "Viewers attached to a worker.")),
      messages_(counters(registry, "diaphane_stream_messages_total", "Messages forwarded.")),
      bytes_(counters(registry, "diaphane_stream_bytes_total", "Message bytes forwarded.")),
      messages_to_worker_(messages_.Add({{"direction", "to_worker"}})),
      messages_to_viewer_(messages_.Add({{"direction", "to_viewer"}})),
      bytes_to_worker_(bytes_.Add({{"direction", "to_worker"}})),
      bytes_to_viewer_(bytes_.Add({{"direction", "to_viewer"}})),
      refusals_(counters(registry, "diaphane_stream_refusals_total",
                         "Connections refused before a stream started.")),
      closes_(counters(registry, "diaphane_stream_closes_total", "Streams closed by the gateway.")),
      workers_lost_(counters(registry, "diaphane_stream_workers_lost_total",
                             "Failed attempts to reach a worker.")
                        .Add({})),
      slow_viewers_(counters(registry, "diaphane_stream_slow_viewers_total",
                             "Viewers disconnected because they stopped reading.")
                        .Add({})) {}

void GatewayMetrics::message(Direction direction, std::size_t bytes) {
  const bool to_worker = direction == Direction::kToWorker;
  (to_worker ? messages_to_worker_ : messages_to_viewer_).Increment();
  (to_worker ? bytes_to_worker_ : bytes_to_viewer_).Increment(static_cast<double>(bytes));
}

void GatewayMetrics::refused(const std::string& reason) {
  refusals_.Add({{"reason", reason}}).Increment();
}

void GatewayMetrics::closed(CloseCode code) {
  closes_.Add({{"code", std::to_string(static_cast<int>(code))}}).Increment();
}

}  // namespace diaphane::api::stream
