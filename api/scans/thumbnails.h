#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
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
  /// A data set that a link leads to, and the ID of the link.
  struct Linked {
    DataSet data_set;
    std::string link_id;
  };
  /// The same for a visitor with a link. `follow` returns where the link leads, or a refusal. It is
  /// called again after a rendering, because the link may have been ended in the meantime.
  Outcome<std::string> get_with_link(const std::function<Outcome<Linked>()>& follow,
                                     const std::string& preset);
  /// Deletes all thumbnails of a data set.
  Result<void> remove(const std::string& data_set_id);

 private:
  /// `find` returns the data set that somebody wants to see, or a refusal.
  Outcome<std::string> get(const std::string& preset, const DataSet& data_set,
                           const std::function<Outcome<DataSet>()>& find);
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
