#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "common/result.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// What is to be kept of a stored volume.
struct CutOrder {
  volume::Region region;
  std::string of;      ///< content hash of the volume that was seen when it was ordered
  std::string result;  ///< of an earlier attempt, told by note_cut(): it may be in place already
};

/// One upload to be made into a volume, or one volume to be cut, as claimed.
struct Job {
  std::string data_set_id;      ///< also the volume's directory
  std::string upload_id;        ///< the file <upload-dir>/<upload_id>.tar
  int attempts = 0;             ///< this one counted
  std::optional<CutOrder> cut;  ///< then there is no upload
  int waits = 0;                ///< how often in a row it has waited, see JobStore::wait
  /// Bytes of storage that the owner's quota leaves for the volume; nothing: there is no limit.
  std::optional<std::uint64_t> quota_left = std::nullopt;
};

/// Jobs that are not done.
struct QueueState {
  std::int64_t jobs = 0;     ///< all of them
  std::int64_t waiting = 0;  ///< of these, jobs for which JobStore::wait was called last
};

/// What a job waits for. It passes without anybody's doing anything about the job itself.
enum class WaitReason {
  kRoom,     ///< a disk is full
  kMemory,   ///< there is too little memory, or the child was killed
  kService,  ///< a disk or a service that is needed is away
};
const char* to_string(WaitReason reason);

/// How a job stands for its claimer.
enum class Hold {
  kOurs,
  kLost,       ///< its lease went to somebody else, or it is done
  kDeleted,    ///< its data set is gone
  kOverQuota,  ///< it was refused instead: the owner's quota has no room for the volume
};

/// The queue in Postgres (migrations/0002). Everything fails with kUnavailable while Postgres is
/// away.
class JobStore {
 public:
  virtual ~JobStore() = default;
  /// The oldest job, of those that nobody holds, of the account that was served longest ago and has
  /// no job under way; what belongs to nobody comes first. It is held by this claimer for a lease;
  /// its data set is "building".
  virtual Result<std::optional<Job>> claim() = 0;
  /// Holds it for another lease.
  virtual Result<Hold> renew(const Job& job) = 0;
  /// `head` is the JSON of what ingest/head found. The data set is "ready" and the job, the
  /// upload's row and (soon) its file are gone: one transaction. kOverQuota: the owner's other data
  /// sets leave no room for `bytes`, so the data set is "refused" and the volume is noted for
  /// disposal.
  virtual Result<Hold> finish_ready(const Job& job, const volume::Header& header,
                                    std::uint64_t bytes, const std::string& head) = 0;
  /// The data set is "refused" with a reason; the rest as above.
  virtual Result<Hold> finish_refused(const Job& job, const std::string& code,
                                      const std::string& text) = 0;
  /// About to put what is left in the place of the volume: from here on the order says which hash
  /// the new one has, and by how much its world has moved (volume/region.h, Cut::shift).
  virtual Result<Hold> note_cut(const Job& job, const std::string& content_hash,
                                const volume::Vector& shift) = 0;
  /// The data set is "ready" again, anonymised, and the order done: pictures made of the old volume
  /// are noted for disposal, presets moved along, the audit log told, in one transaction.
  virtual Result<Hold> finish_cut(const Job& job, const volume::Header& header, std::uint64_t bytes,
                                  const std::string& head) = 0;
  /// The data set is "ready" as it was before; why is told to its owner.
  virtual Result<Hold> finish_cut_refused(const Job& job, const std::string& text) = 0;
  /// Gives it back unharmed: this attempt does not count.
  virtual Result<void> release(const Job& job) = 0;
  /// Gives it back to be tried again after `pause`, and says to its owner what it waits for. The
  /// attempt counts only where the job itself may be the cause.
  virtual Result<void> wait(const Job& job, WaitReason reason, std::chrono::milliseconds pause,
                            bool count_attempt) = 0;
  /// Gives it back to a worker that has more memory. The attempt does not count.
  virtual Result<void> leave_to_large(const Job& job) = 0;
  /// The upload's file is gone from disk.
  virtual Result<void> upload_removed(const std::string& upload_id) = 0;
  virtual Result<QueueState> queue() = 0;
};

}  // namespace diaphane::ingest
