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

/// What renderd counts, by intention; thread-safe. The only place that names the metrics.
class Metrics {
 public:
  explicit Metrics(prometheus::Registry& registry);
  ~Metrics();

  void sessions(std::size_t live);
  /// Workers that were asked to help with this one's pictures; pictures of others helped with.
  void lending(std::size_t borrowed, std::size_t helped);
  void rendered(std::uint32_t samples, double seconds, std::uint64_t dropped);
  void encoded(double seconds);
  void frame_sent(std::size_t bytes);
  void slice_sent(std::size_t bytes);
  void frames_skipped(std::uint64_t count);
  /// Server side: from the arrival of an input to the sending of the first frame that shows it.
  void input_to_frame(double seconds);
  void volumes(std::uint64_t bytes);
  /// What the node's copies of volumes did until now; by one thread at a time.
  void volume_copies(const volume::NodeCache::Counts& counts);
  void still(double seconds);
  /// `status` is a gRPC status name: a closed set.
  void grpc_error(const std::string& status);
  void redis_error();
  /// Where the device's time went until now ("busy" is all; its parts overlap); by one thread at a
  /// time.
  void device(const RunnerTimes& times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::render
