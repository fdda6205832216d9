#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "api/scans/data_sets.h"
#include "api/shared/placement.h"
#include "api/shared/problem.h"

namespace diaphane::api {

/// Thumbnails of ready data sets. A worker renders each once, and the file is kept in `<cache
/// directory>/thumbnails/<data set>/<preset>.<version of the looks>.jpg`. Thread-safe.
class Thumbnails {
 public:
  /// At most `slots` are rendered at the same time, and a few requests wait for `patience`. All
  /// others get kBusy, so that thumbnails never block all threads of the API.
  Thumbnails(DataSets& data_sets, Stills& stills, std::string cache_directory, int slots = 2,
             std::chrono::milliseconds patience = std::chrono::seconds(20));

  /// Returns the path below the cache directory, or kNotFound (also for an unknown preset),
  /// kNotReady, kNoWorker or kBusy.
  Outcome<std::string> get(const Principal& who, const std::string& data_set_id,
                           const std::string& preset);
  /// Deletes all thumbnails of a data set.
  Result<void> remove(const std::string& data_set_id);

 private:
  /// Waits while another request renders the thumbnail. Returns false after `patience_`, or if too
  /// many requests wait.
  bool wait_for_render(std::unique_lock<std::mutex>& lock, const std::string& path);
  /// Returns whether the file exists and is newer than the anonymisation of its data set, if any.
  bool is_current(const std::string& path, const std::optional<Time>& cut_at) const;
  Outcome<void> render(const std::string& data_set_id, const std::string& preset,
                       const std::string& path);

  DataSets& data_sets_;
  Stills& stills_;
  const std::string directory_;
  const std::size_t slots_;
  const std::chrono::milliseconds patience_;
  std::mutex mutex_;
  std::condition_variable done_;
  std::set<std::string> rendering_;  ///< paths of thumbnails being rendered
  int waiting_ = 0;                  ///< number of waiting requests
};

}  // namespace diaphane::api
