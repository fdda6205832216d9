#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "volume/node_cache.h"

namespace prometheus {
class Registry;
}

namespace diaphane::render {

struct RunnerTimes;

/// The metrics of renderd, recorded by purpose. No other file names a metric. Thread-safe.
class Metrics {
 public:
  explicit Metrics(prometheus::Registry& registry);
  ~Metrics();

  void sessions(std::size_t live);
  /// Sets the number of workers that help with this worker's pictures (`borrowed`), and of pictures
  /// of other workers that this one helps with (`helped`).
  void lending(std::size_t borrowed, std::size_t helped);
  void rendered(std::uint32_t samples, double seconds, std::uint64_t dropped);
  void encoded(double seconds);
  void frame_sent(std::size_t bytes);
  void slice_sent(std::size_t bytes);
  void frames_skipped(std::uint64_t count);
  /// Records the latency on the server, from the arrival of an input to the sending of the first
  /// frame that shows it.
  void input_to_frame(double seconds);
  /// Records the seconds from a viewer's last input to a picture at rest with at most 5% error.
  void time_to_five_percent(double seconds);
  /// Records the error of a picture at rest when the viewer left it.
  void error_at_rest(double error);
  void volumes(std::uint64_t bytes);
  /// Sets the total counts of the node's copies of volumes. Not thread-safe.
  void volume_copies(const volume::NodeCache::Counts& counts);
  void still(double seconds);
  /// Counts an error. `status` is a gRPC status name, from a closed set.
  void grpc_error(const std::string& status);
  void redis_error();
  /// Sets the device's total times. "busy" is their total, and its parts overlap. Not thread-safe.
  void device(const RunnerTimes& times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::render
