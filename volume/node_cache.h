#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/result.h"
#include "volume/sealed_copy.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// A copy in the cache, with the properties that decide whether it is evicted.
struct CachedCopy {
  std::string name;
  std::uint64_t bytes = 0;
  std::int64_t used = 0;  ///< time of the last read, in any unit
};

/// Returns the copies to evict, least recently used first, so that `needed` further bytes fit
/// within `bound`. Returns nullopt if evicting all copies does not free enough space.
std::optional<std::vector<std::string>> make_room(std::vector<CachedCopy> copies,
                                                  std::uint64_t needed, std::uint64_t bound);

/// A cache of volumes on a local disk of this node, for a store that is slow to read. It always
/// returns the volume that the store has now: the header is read from the store each time, its
/// content hash selects the copy, and the copy's bytes are verified against this hash. A damaged
/// copy is removed, and the volume is read from the store. Copies are encrypted (sealed_copy.h).
///
/// Several processes may share one folder. If the cache fails (for example, because the disk is
/// full or the folder was removed), reads still succeed. Thread-safe.
class NodeCache {
 public:
  struct Options {
    std::string folder;       ///< created if necessary, readable only by this user
    std::uint64_t bound = 0;  ///< maximum bytes of all copies, including those being written
    std::string store;
    /// Period after which copies of removed volumes are deleted, by one of the processes that share
    /// the folder. With 0, this happens only when sweep() is called.
    std::chrono::milliseconds sweep_period{10000};
  };
  struct Counts {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::uint64_t damaged = 0;  ///< damaged copies, which also count as misses
    std::uint64_t kept = 0;
    std::uint64_t refused = 0;  ///< not kept: too large, disk full, or busy with another copy
    std::uint64_t evicted = 0;
    std::uint64_t erased = 0;  ///< copies whose volume was erased or replaced
    std::uint64_t bytes = 0;   ///< bytes in the folder when it was last listed
  };

  /// Opens the folder. Returns kUnsupported without libsodium, or kUnavailable if it cannot be
  /// used.
  static Result<std::unique_ptr<NodeCache>> open(Options options);
  /// Aborts a copy that is being written.
  ~NodeCache();
  NodeCache(const NodeCache&) = delete;
  NodeCache& operator=(const NodeCache&) = delete;

  /// Reads one phase of the volume `id`, like volume::read() does from the store. Copies are kept
  /// only of scans without phases, because a checksum exists only for all phases together.
  Result<Volume> read(const std::string& id, std::uint32_t phase = 0);

  /// Copies a volume that read() returned, in a background thread, unless the copy exists.
  void keep(Volume volume);
  /// Returns whether keep() would make a copy of this volume, because there is none yet.
  bool misses(const Volume& volume) const;
  /// Waits until the copy that keep() started is finished.
  void wait();

  /// Deletes copies whose volume was erased or replaced, and files that killed writers left. Does
  /// nothing if any process has swept the folder within the period.
  void sweep();

  Counts counts() const;

 private:
  explicit NodeCache(Options options);
  bool read_copy(const std::string& name, const Seal& seal, const Header& header,
                 std::vector<std::int16_t>& voxels);
  bool write_copy(const Volume& volume, const std::stop_token& stop);
  void write_all_kept(const std::stop_token& stop);
  void sweep_always(const std::stop_token& stop);
  std::vector<CachedCopy> list() const;
  std::string path(const std::string& name) const { return options_.folder + "/" + name; }

  const Options options_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  Counts counts_;
  std::optional<Volume> next_;
  bool busy_ = false;
  std::jthread writer_, sweeper_;
};

}  // namespace diaphane::volume
