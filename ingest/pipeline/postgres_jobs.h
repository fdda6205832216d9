#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "ingest/pipeline/job_store.h"

namespace diaphane::ingest {

/// The queue over libpqxx. Uses one connection, which is opened on demand and reopened after a
/// loss. Not thread-safe.
class PostgresJobs final : public JobStore {
 public:
  struct Options {
    std::string url;
    std::string claimer;  ///< identifies this worker in leases; different at each start
    std::string process;  ///< common prefix of the names of all claimers in this process
    std::chrono::milliseconds lease{5000};
    /// Claims only jobs whose uploads, or volumes to cut, are at most this large. 0: all jobs.
    std::uint64_t light_bytes = 0;
    /// Pause of a job that was interrupted twice, doubled with each further interruption.
    std::chrono::milliseconds first_pause{1000};
    std::chrono::milliseconds longest_pause{600000};
  };
  explicit PostgresJobs(Options options);
  ~PostgresJobs() override;

  Result<std::optional<Job>> claim() override;
  bool wait_for_work(std::chrono::milliseconds longest) override;
  Result<Hold> renew(const Job& job) override;
  Result<Hold> finish_ready(const Job& job, const volume::Header& header, std::uint64_t bytes,
                            const std::string& head, const std::string& frame) override;
  Result<Hold> finish_refused(const Job& job, const std::string& code,
                              const std::string& text) override;
  Result<Hold> note_cut(const Job& job, const std::string& content_hash,
                        const volume::Vector& shift) override;
  Result<Hold> finish_cut(const Job& job, const volume::Header& header, std::uint64_t bytes,
                          const std::string& head) override;
  Result<Hold> finish_cut_refused(const Job& job, const std::string& text) override;
  Result<Hold> finish_labels(const Job& job, const volume::LabelSet& labels,
                             std::uint64_t bytes) override;
  Result<Hold> finish_labels_refused(const Job& job, const std::string& code,
                                     const std::string& text) override;
  Result<void> release(const Job& job) override;
  Result<void> wait(const Job& job, WaitReason reason, std::chrono::milliseconds pause,
                    bool count_attempt) override;
  Result<void> leave_to_large(const Job& job) override;
  Result<bool> files_are_kept() override;
  Result<void> upload_removed(const std::string& upload_id) override;
  Result<QueueState> queue() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::ingest
