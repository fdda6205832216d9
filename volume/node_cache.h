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

/// A copy in the cache, as the choice of what goes sees it.
struct CachedCopy {
  std::string name;
  std::uint64_t bytes = 0;
  std::int64_t used = 0;  ///< when somebody read it last; any unit
};

/// Which copies go, the least recently used first, so that `needed` bytes fit beside the others
/// within `bound`; nullopt when not even an empty cache has room.
std::optional<std::vector<std::string>> make_room(std::vector<CachedCopy> copies,
                                                  std::uint64_t needed, std::uint64_t bound);

/// Copies of volumes on a disk of this node, for a store that is slow to read. What is read from
/// here is always what the store has now: the header comes from the store each time, its content
/// hash decides which copy fits, and the copy's bytes are held against that hash. A copy that is
/// damaged is removed and the store is read. Copies are enciphered (sealed_copy.h).
///
/// Several processes may use one folder at once. Nothing that fails here (a full disk, a folder
/// that went) fails a read. Thread-safe.
class NodeCache {
 public:
  struct Options {
    std::string folder;       ///< made if it is not there; nobody else may read it
    std::uint64_t bound = 0;  ///< bytes of all copies, and of those just being written
    std::string store;
    /// Copies whose original is gone are removed so often, by one of the folder's processes; 0:
    /// only when sweep() is called.
    std::chrono::milliseconds sweep_period{10000};
  };
  struct Counts {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::uint64_t damaged = 0;  ///< among the misses
    std::uint64_t kept = 0;
    std::uint64_t refused = 0;  ///< not kept: too large, a full disk, still busy with another
    std::uint64_t evicted = 0;
    std::uint64_t erased = 0;  ///< their originals were gone
    std::uint64_t bytes = 0;   ///< in the folder, at the last look
  };

  /// kUnsupported without libsodium; kUnavailable when the folder cannot be used.
  static Result<std::unique_ptr<NodeCache>> open(Options options);
  /// What is being written is given up.
  ~NodeCache();
  NodeCache(const NodeCache&) = delete;
  NodeCache& operator=(const NodeCache&) = delete;

  /// As volume::read() of the volume `id` in the store.
  Result<Volume> read(const std::string& id);

  /// Makes a copy of what read() gave, by a thread of its own, unless there is one.
  void keep(Volume volume);
  /// Until what keep() was given is done.
  void wait();

  /// Removes copies whose original is gone, and what killed writers left; not sooner than the
  /// period after the folder's last sweep, whoever did it.
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
