#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "ingest/pipeline/job_store.h"

namespace diaphane::ingest {

/// The queue by libpqxx; one connection, opened when needed and again after it was lost. For one
/// thread.
class PostgresJobs final : public JobStore {
 public:
  struct Options {
    std::string url;
    std::string claimer;  ///< names this worker in leases; a new name at each start
    std::chrono::milliseconds lease{5000};
    /// Only jobs whose uploads, and cuts whose volumes, are no larger; 0: all.
    std::uint64_t light_bytes = 0;
  };
  explicit PostgresJobs(Options options);
  ~PostgresJobs() override;

  Result<std::optional<Job>> claim() override;
  Result<Hold> renew(const Job& job) override;
  Result<Hold> finish_ready(const Job& job, const volume::Header& header, std::uint64_t bytes,
                            const std::string& head) override;
  Result<Hold> finish_refused(const Job& job, const std::string& code,
                              const std::string& text) override;
  Result<Hold> note_cut(const Job& job, const std::string& content_hash,
                        const volume::Vector& shift) override;
  Result<Hold> finish_cut(const Job& job, const volume::Header& header, std::uint64_t bytes,
                          const std::string& head) override;
  Result<Hold> finish_cut_refused(const Job& job, const std::string& text) override;
  Result<void> release(const Job& job) override;
  Result<void> wait(const Job& job, WaitReason reason, std::chrono::milliseconds pause,
                    bool count_attempt) override;
  Result<void> leave_to_large(const Job& job) override;
  Result<void> upload_removed(const std::string& upload_id) override;
  Result<QueueState> queue() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::ingest
