#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "ingest/pipeline/builder.h"
#include "ingest/pipeline/export_jobs.h"

namespace diaphane::ingest {

/// Makes exports of stored scans, one after another. A temporary condition ends no export: it waits
/// and is tried again. An export that ran out of memory or time, or whose worker ended, is tried
/// `most_attempts` times.
class ExportWorker {
 public:
  using Make = std::function<Result<Build>(const ExportInput&, const Builder::ShouldContinue&)>;
  struct Options {
    std::string volume_dir;
    std::string export_dir;  ///< is created when it is needed
    std::chrono::milliseconds renew{1500};
    std::chrono::milliseconds first_pause{1000};  ///< pause of a waiting export; doubled each time
    std::chrono::milliseconds longest_pause{60000};
    int most_attempts = 3;
  };

  /// `make` is SandboxBuilder::export_scan.
  ExportWorker(Options options, ExportJobs& jobs, Make make)
      : options_(std::move(options)), jobs_(jobs), make_(std::move(make)) {}

  /// Makes one export if there is one, and returns whether there was. Gives it back when
  /// `is_stopping` returns true.
  bool work_once(const std::function<bool()>& is_stopping);

 private:
  void work(const ExportJob& job, const std::function<bool()>& is_stopping);
  /// Handles a build without a file.
  void settle(const ExportJob& job, const Build& build);
  void finish(const ExportJob& job, const std::string& unfinished, const Build& build);
  void wait(const ExportJob& job, const Error& why);

  Options options_;
  ExportJobs& jobs_;
  Make make_;
};

}  // namespace diaphane::ingest
