#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "ingest/pipeline/align_jobs.h"
#include "ingest/pipeline/builder.h"

namespace diaphane::ingest {

/// Aligns pairs of stored scans, one after another. A temporary condition ends no alignment: it
/// waits and is tried again. One that ran out of memory or time, or whose worker ended, is tried
/// `most_attempts` times.
class AlignWorker {
 public:
  using Align = std::function<Result<Build>(const AlignInput&, const Builder::ShouldContinue&)>;
  struct Options {
    std::string volume_dir;
    std::chrono::milliseconds renew{1500};
    std::chrono::milliseconds first_pause{1000};  ///< pause of a waiting one; doubled each time
    std::chrono::milliseconds longest_pause{60000};
    int most_attempts = 3;
  };

  /// `align` is SandboxBuilder::align.
  AlignWorker(Options options, AlignJobs& jobs, Align align)
      : options_(std::move(options)), jobs_(jobs), align_(std::move(align)) {}

  /// Makes one alignment if there is one, and returns whether there was. Gives it back when
  /// `is_stopping` returns true.
  bool work_once(const std::function<bool()>& is_stopping);

 private:
  void work(const AlignJob& job, const std::function<bool()>& is_stopping);
  /// Handles the end of a child.
  void settle(const AlignJob& job, const Build& build);
  void wait(const AlignJob& job, const Error& why);

  Options options_;
  AlignJobs& jobs_;
  Align align_;
};

}  // namespace diaphane::ingest
