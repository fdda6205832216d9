#include "renderd/serve/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <algorithm>
#include <utility>

#include "renderd/schedule/runner.h"

namespace diaphane::render {
namespace {

prometheus::Counter& counter(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

prometheus::Gauge& gauge(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildGauge().Name(name).Help(help).Register(registry).Add({});
}

prometheus::Histogram& histogram(prometheus::Registry& registry, const char* name, const char* help,
                                 prometheus::Histogram::BucketBoundaries boundaries) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry).Add(
      {}, std::move(boundaries));
}

prometheus::Histogram& latency(prometheus::Registry& registry, const char* name, const char* help) {
  return histogram(registry, name, help,
                   {0.005, 0.01, 0.02, 0.033, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5, 1, 2, 5});
}

}  // namespace

struct Metrics::Impl {
  explicit Impl(prometheus::Registry& r)
      : sessions(gauge(r, "diaphane_renderd_sessions", "Sessions rendered on this device.")),
        borrowed(gauge(r, "diaphane_renderd_helpers", "Peer workers that assist this worker.")),
        helped(gauge(r, "diaphane_renderd_helped_pictures",
                     "Images of peer workers that this worker helps to render.")),
        samples(counter(r, "diaphane_renderd_samples_total", "Samples per pixel rendered.")),
        render_seconds(
            counter(r, "diaphane_renderd_render_seconds_total", "Time spent rendering.")),
        dropped(counter(r, "diaphane_renderd_dropped_samples_total",
                        "Samples dropped because they were not finite.")),
        encode_seconds(counter(r, "diaphane_renderd_encode_seconds_total", "Time spent encoding.")),
        frames(counter(r, "diaphane_renderd_frames_sent_total", "Frames sent to viewers.")),
        frame_bytes(counter(r, "diaphane_renderd_frame_bytes_total", "Bytes of frames sent.")),
        skipped(counter(r, "diaphane_renderd_frames_skipped_total",
                        "Frames replaced by a newer frame before they were sent.")),
        slices(counter(r, "diaphane_renderd_slices_sent_total", "Exact slices sent to viewers.")),
        slice_bytes(counter(r, "diaphane_renderd_slice_bytes_total", "Bytes of slices sent.")),
        input_to_frame(latency(r, "diaphane_renderd_input_to_frame_seconds",
                               "Time from an input to sending the first frame that shows it.")),
        time_to_five_percent(
            histogram(r, "diaphane_renderd_time_to_5_percent_seconds",
                      "Time from the last input of a viewer until the error of the picture at rest "
                      "is at most 0.05.",
                      {0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1, 1.5, 2, 3, 5, 10, 20, 30, 60})),
        error_at_rest(histogram(
            r, "diaphane_renderd_error_at_rest_ratio",
            "Estimated relative RMSE of the picture at rest when its viewer left it.",
            {0.005, 0.0075, 0.01, 0.015, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5, 1})),
        volume_bytes(
            gauge(r, "diaphane_renderd_volume_bytes", "Bytes of volumes in device memory.")),
        copy_bytes(gauge(r, "diaphane_renderd_volume_copy_bytes",
                         "Bytes of volume copies on this node's disk.")),
        copies(prometheus::BuildCounter()
                   .Name("diaphane_renderd_volume_copies_total")
                   .Help("Outcomes of volume copies on this node's disk.")
                   .Register(r)),
        stills(latency(r, "diaphane_renderd_still_seconds",
                       "Time to render an image without a session.")),
        grpc_errors(prometheus::BuildCounter()
                        .Name("diaphane_renderd_grpc_errors_total")
                        .Help("Failed gRPC calls, by status.")
                        .Register(r)),
        redis_errors(counter(r, "diaphane_renderd_redis_errors_total",
                             "Heartbeats and scenes that could not be written to Redis.")),
        device_seconds(prometheus::BuildCounter()
                           .Name("diaphane_renderd_device_seconds_total")
                           .Help("Time spent by the device thread, by activity.")
                           .Register(r)) {}

  prometheus::Gauge& sessions;
  prometheus::Gauge& borrowed;
  prometheus::Gauge& helped;
  prometheus::Counter& samples;
  prometheus::Counter& render_seconds;
  prometheus::Counter& dropped;
  prometheus::Counter& encode_seconds;
  prometheus::Counter& frames;
  prometheus::Counter& frame_bytes;
  prometheus::Counter& skipped;
  prometheus::Counter& slices;
  prometheus::Counter& slice_bytes;
  prometheus::Histogram& input_to_frame;
  prometheus::Histogram& time_to_five_percent;
  prometheus::Histogram& error_at_rest;
  prometheus::Gauge& volume_bytes;
  prometheus::Gauge& copy_bytes;
  prometheus::Family<prometheus::Counter>& copies;
  prometheus::Histogram& stills;
  prometheus::Family<prometheus::Counter>& grpc_errors;
  prometheus::Counter& redis_errors;
  prometheus::Family<prometheus::Counter>& device_seconds;
};

Metrics::Metrics(prometheus::Registry& registry) : impl_(std::make_unique<Impl>(registry)) {}
Metrics::~Metrics() = default;

void Metrics::sessions(std::size_t live) { impl_->sessions.Set(static_cast<double>(live)); }
void Metrics::lending(std::size_t borrowed, std::size_t helped) {
  impl_->borrowed.Set(static_cast<double>(borrowed));
  impl_->helped.Set(static_cast<double>(helped));
}
void Metrics::rendered(std::uint32_t samples, double seconds, std::uint64_t dropped) {
  impl_->samples.Increment(samples);
  impl_->render_seconds.Increment(seconds);
  impl_->dropped.Increment(static_cast<double>(dropped));
}
void Metrics::encoded(double seconds) { impl_->encode_seconds.Increment(seconds); }
void Metrics::frame_sent(std::size_t bytes) {
  impl_->frames.Increment();
  impl_->frame_bytes.Increment(static_cast<double>(bytes));
}
void Metrics::frames_skipped(std::uint64_t count) {
  impl_->skipped.Increment(static_cast<double>(count));
}
void Metrics::slice_sent(std::size_t bytes) {
  impl_->slices.Increment();
  impl_->slice_bytes.Increment(static_cast<double>(bytes));
}
void Metrics::input_to_frame(double seconds) { impl_->input_to_frame.Observe(seconds); }
void Metrics::time_to_five_percent(double seconds) { impl_->time_to_five_percent.Observe(seconds); }
void Metrics::error_at_rest(double error) { impl_->error_at_rest.Observe(error); }
void Metrics::volumes(std::uint64_t bytes) { impl_->volume_bytes.Set(static_cast<double>(bytes)); }
void Metrics::volume_copies(const volume::NodeCache::Counts& counts) {
  impl_->copy_bytes.Set(static_cast<double>(counts.bytes));
  const auto increase_to = [&](const char* what, std::uint64_t count) {
    prometheus::Counter& counter = impl_->copies.Add({{"what", what}});
    counter.Increment(std::max(0.0, static_cast<double>(count) - counter.Value()));
  };
  increase_to("hit", counts.hits);
  increase_to("miss", counts.misses);
  increase_to("damaged", counts.damaged);
  increase_to("kept", counts.kept);
  increase_to("refused", counts.refused);
  increase_to("evicted", counts.evicted);
  increase_to("erased", counts.erased);
}
void Metrics::still(double seconds) { impl_->stills.Observe(seconds); }
void Metrics::grpc_error(const std::string& status) {
  impl_->grpc_errors.Add({{"status", status}}).Increment();
}
void Metrics::redis_error() { impl_->redis_errors.Increment(); }
void Metrics::device(const RunnerTimes& times) {
  const auto increase_to = [&](const char* part, double seconds) {
    prometheus::Counter& counter = impl_->device_seconds.Add({{"part", part}});
    counter.Increment(std::max(0.0, seconds - counter.Value()));
  };
  increase_to("busy", times.busy);
  increase_to("rendering", times.rendering);
  increase_to("scenes", times.scenes);
  increase_to("pictures", times.pictures);
  increase_to("deciding", times.deciding);
  increase_to("idle", times.idle);
}

}  // namespace diaphane::render
