#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "common/result.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// An order to keep only a part of a stored volume.
struct CutOrder {
  volume::Region region;
  std::string of;  ///< content hash of the volume at the time of the order
  /// Hash from note_cut() in an earlier attempt; that volume may already be in place.
  std::string result;
};

/// A claimed job: an upload to build into a volume, an uploaded file of labels for a scan, or a
/// volume to cut.
struct Job {
  std::string data_set_id;  ///< also the name of the volume's directory
  std::string upload_id;    ///< the file <upload-dir>/<upload_id>.tar
  int attempts = 0;         ///< earlier attempts that failed because memory or CPU time was short
  std::optional<CutOrder> cut;  ///< if set, there is no upload
  bool labels = false;          ///< the upload is a file of labels for a scan that is ready
  int waits = 0;                ///< number of consecutive waits, see JobStore::wait
  int interruptions = 0;        ///< how often its claimer ended without a result, see claim()
  /// Bytes that the owner's quota leaves for the volume and its labels. nullopt: no limit.
  std::optional<std::uint64_t> quota_left = std::nullopt;
};

/// Numbers of unfinished jobs.
struct QueueState {
  std::int64_t jobs = 0;     ///< all of them
  std::int64_t waiting = 0;  ///< of these, jobs that wait for a condition to pass
  std::int64_t suspect = 0;  ///< of these, jobs that were interrupted more than once
};

/// A temporary condition that a job waits for. It passes without a change to the job itself.
enum class WaitReason {
  kRoom,     ///< a disk is full
  kMemory,   ///< too little memory, or the child was killed
  kService,  ///< a required disk or service is unavailable
};
const char* to_string(WaitReason reason);

/// Whether the claimer still holds the job.
enum class Hold {
  kOurs,
  kLost,       ///< its lease went to another claimer, or it is done
  kDeleted,    ///< its data set was deleted
  kOverQuota,  ///< it was refused because the owner's quota has no room for the volume
};

/// The queue in Postgres (migrations/0002). Every call fails with kUnavailable while Postgres is
/// unavailable.
class JobStore {
 public:
  virtual ~JobStore() = default;
  /// Claims the oldest unheld job of the account that was served longest ago and has no job in
  /// progress. Jobs without an owner come first. The claimer holds the job for one lease, and its
  /// data set is "building".
  ///
  /// An expired lease shows that its claimer ended and says nothing about the upload, so the job is
  /// requeued without counting an attempt. From the second time, it waits longer each time, and
  /// jobs of others come first for a while. It then runs while its claimer's process does nothing
  /// else, so that it interrupts no other job if it ends that process again.
  virtual Result<std::optional<Job>> claim() = 0;
  /// Waits for a job, an export or an alignment to be ordered, but no longer than `longest`.
  /// Returns whether there may be one. Jobs that become due without an order, such as those of a
  /// claimer that ended, are found only by claim().
  virtual bool wait_for_work(std::chrono::milliseconds longest) = 0;
  /// Extends the lease.
  virtual Result<Hold> renew(const Job& job) = 0;
  /// Completes a job with a volume. `head` is the JSON of the head finding (ingest/head), and
  /// `frame` is the UID of its frame of reference in disguise (volume/frame_of_reference.h), or
  /// empty. It is stored as a hash that shows which scans of one account share it. In one
  /// transaction, the data set becomes "ready", and the job and the upload's row are deleted and
  /// its file is noted for deletion. Returns kOverQuota if the owner's other data sets leave no
  /// room for `bytes`, so that the data set becomes "refused" and the volume is noted for disposal.
  virtual Result<Hold> finish_ready(const Job& job, const volume::Header& header,
                                    std::uint64_t bytes, const std::string& head,
                                    const std::string& frame) = 0;
  /// Marks the data set as "refused" with a reason, and ends the job and the upload like
  /// finish_ready().
  virtual Result<Hold> finish_refused(const Job& job, const std::string& code,
                                      const std::string& text) = 0;
  /// Announces that the kept part is about to replace the volume. From now on, the order contains
  /// the hash of the new volume and the shift of its world origin (volume/region.h, Cut::shift).
  virtual Result<Hold> note_cut(const Job& job, const std::string& content_hash,
                                const volume::Vector& shift) = 0;
  /// Completes a cut. In one transaction, makes the data set "ready" again and anonymised,
  /// completes the order, notes images of the old volume for disposal, deletes the scan's marks and
  /// the record of its labels, moves presets along, and writes to the audit log.
  virtual Result<Hold> finish_cut(const Job& job, const volume::Header& header, std::uint64_t bytes,
                                  const std::string& head) = 0;
  /// Makes the data set "ready" unchanged, and gives its owner the reason.
  virtual Result<Hold> finish_cut_refused(const Job& job, const std::string& text) = 0;
  /// Records that the scan has the labels of the upload, and ends the job and the upload like
  /// finish_ready().
  virtual Result<Hold> finish_labels(const Job& job, const volume::LabelSet& labels,
                                     std::uint64_t bytes) = 0;
  /// Gives the owner the reason why the labels were refused. The scan keeps its earlier labels.
  virtual Result<Hold> finish_labels_refused(const Job& job, const std::string& code,
                                             const std::string& text) = 0;
  /// Requeues the job without counting this attempt.
  virtual Result<void> release(const Job& job) = 0;
  /// Requeues the job to be tried again after `pause`, and shows its owner what it waits for. The
  /// attempt counts only if the job itself may be the cause.
  virtual Result<void> wait(const Job& job, WaitReason reason, std::chrono::milliseconds pause,
                            bool count_attempt) = 0;
  /// Requeues the job for a worker with more memory. The attempt does not count.
  virtual Result<void> leave_to_large(const Job& job) = 0;
  /// Whether a backup copies files now. Then none that a row named before may be deleted.
  virtual Result<bool> files_are_kept() = 0;
  /// Records that the upload's file was deleted from the disk.
  virtual Result<void> upload_removed(const std::string& upload_id) = 0;
  virtual Result<QueueState> queue() = 0;
};

}  // namespace diaphane::ingest
