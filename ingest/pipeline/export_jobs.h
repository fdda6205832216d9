#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "ingest/export/export_scan.h"
#include "ingest/pipeline/lease.h"

namespace diaphane::ingest {

/// A claimed export of a stored scan.
struct ExportJob {
  std::string id;  ///< also the name of its file
  std::string data_set_id;
  ExportOrder order;
  int attempts = 0;  ///< earlier claims that ended without a result
  int waits = 0;     ///< number of consecutive waits
};

/// Serialises an order for the child process.
std::string to_text(const ExportOrder& order);
std::optional<ExportOrder> export_order_of(const std::string& text);

/// The queue of exports in Postgres (migrations/0027). Every call fails with kUnavailable while
/// Postgres is unavailable.
class ExportJobs {
 public:
  virtual ~ExportJobs() = default;
  /// Claims the oldest export that nobody holds and whose scan is ready, for one lease.
  virtual Result<std::optional<ExportJob>> claim() = 0;
  /// Extends the lease. Returns false if the export was deleted or went to another claimer.
  virtual Result<bool> renew(const ExportJob& job) = 0;
  /// Makes the export ready. Returns false, and changes nothing, if it was deleted, is held by
  /// another claimer, or its scan is no longer ready.
  virtual Result<bool> finish(const ExportJob& job, std::uint64_t bytes) = 0;
  /// Gives the user the reason why the export failed.
  virtual Result<void> fail_with(const ExportJob& job, const std::string& code,
                                 const std::string& text) = 0;
  /// Requeues the export to be tried again after `pause`. The attempt counts only if the export
  /// itself may be the cause. Otherwise `waiting` tells the user that it waits.
  virtual Result<void> put_back(const ExportJob& job, std::chrono::milliseconds pause, bool waiting,
                                bool count_attempt) = 0;
};

/// The queue over libpqxx. Not thread-safe.
class PostgresExports final : public ExportJobs {
 public:
  explicit PostgresExports(LeaseOptions options);
  ~PostgresExports() override;

  Result<std::optional<ExportJob>> claim() override;
  Result<bool> renew(const ExportJob& job) override;
  Result<bool> finish(const ExportJob& job, std::uint64_t bytes) override;
  Result<void> fail_with(const ExportJob& job, const std::string& code,
                         const std::string& text) override;
  Result<void> put_back(const ExportJob& job, std::chrono::milliseconds pause, bool waiting,
                        bool count_attempt) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::ingest
