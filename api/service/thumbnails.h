#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "api/service/data_sets.h"
#include "api/service/placement.h"
#include "api/service/problem.h"

namespace diaphane::api {

/// Small pictures of ready data sets, rendered by a worker once and kept in
/// `<cache directory>/thumbnails/<data set>/<preset>.jpg`. Thread-safe.
class Thumbnails {
 public:
  /// At most `slots` are rendered at once, and a few requests wait for one of them; all others are
  /// refused with kBusy, so that pictures never hold all threads of the API.
  Thumbnails(DataSets& data_sets, Stills& stills, std::string cache_directory, int slots = 2);

  /// The file's path below the cache directory. kNotFound (also an unknown preset), kNotReady,
  /// kNoWorker, kBusy.
  Outcome<std::string> get(const Principal& who, const std::string& data_set_id,
                           const std::string& preset);
  /// Forgets all pictures of a data set.
  Result<void> remove(const std::string& data_set_id);

 private:
  /// False when the picture is still being rendered: for too long, or too many wait already.
  bool wait_for_render(std::unique_lock<std::mutex>& lock, const std::string& path);
  /// It is there, and no older than the cut of what it shows.
  bool is_current(const std::string& path, const std::optional<Time>& cut_at) const;
  Outcome<void> render(const std::string& data_set_id, const std::string& preset,
                       const std::string& path);

  DataSets& data_sets_;
  Stills& stills_;
  const std::string directory_;
  const std::size_t slots_;
  std::mutex mutex_;
  std::condition_variable done_;
  std::set<std::string> rendering_;  ///< paths
  int waiting_ = 0;                  ///< requests
};

}  // namespace diaphane::api
