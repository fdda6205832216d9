#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "ingest/pipeline/lease.h"
#include "ingest/registration/register.h"

namespace diaphane::ingest {

/// A claimed alignment of two stored scans.
struct AlignJob {
  std::string moving, fixed;  ///< ids of the data sets
  int attempts = 0;           ///< earlier claims that ended without a result
  int waits = 0;              ///< number of consecutive waits
};

/// The queue of alignments in Postgres (migrations/0031). Every call fails with kUnavailable while
/// Postgres is unavailable.
class AlignJobs {
 public:
  virtual ~AlignJobs() = default;
  /// Claims the oldest alignment that nobody holds and whose scans are ready, for one lease.
  virtual Result<std::optional<AlignJob>> claim() = 0;
  /// Extends the lease. Returns false if the alignment was deleted or went to another claimer.
  virtual Result<bool> renew(const AlignJob& job) = 0;
  /// Stores the result. Returns false, and changes nothing, if the alignment was deleted, as when a
  /// scan was anonymised, or is held by another claimer.
  virtual Result<bool> finish(const AlignJob& job, const RigidAlignment& found) = 0;
  /// Gives the user the reason why the alignment failed, as a code.
  virtual Result<void> fail_with(const AlignJob& job, const std::string& reason) = 0;
  /// Requeues the alignment to be tried again after `pause`. `count_attempt`, `waiting`: as in
  /// ExportJobs::put_back().
  virtual Result<void> put_back(const AlignJob& job, std::chrono::milliseconds pause, bool waiting,
                                bool count_attempt) = 0;
};

/// The queue over libpqxx. Not thread-safe.
class PostgresAlignments final : public AlignJobs {
 public:
  explicit PostgresAlignments(LeaseOptions options);
  ~PostgresAlignments() override;

  Result<std::optional<AlignJob>> claim() override;
  Result<bool> renew(const AlignJob& job) override;
  Result<bool> finish(const AlignJob& job, const RigidAlignment& found) override;
  Result<void> fail_with(const AlignJob& job, const std::string& reason) override;
  Result<void> put_back(const AlignJob& job, std::chrono::milliseconds pause, bool waiting,
                        bool count_attempt) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::ingest
