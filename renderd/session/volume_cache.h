#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// The volumes on one device, by volume id: each loaded once for all who look at it, kept after the
/// last one left, and evicted least-recently-used first when the bound is reached. What somebody
/// holds is never evicted. Loading happens on threads of its own. Thread-safe.
class VolumeCache {
 public:
  using Handle = std::shared_ptr<const DeviceVolume>;
  using Load = std::function<Result<Handle>(const std::string& id)>;
  using Ready = std::function<void(Result<Handle>)>;

  /// The content hash of what the store has under this id now, empty when it has nothing; nullopt
  /// when it cannot say just now, and then no copy is thought outdated.
  using Stored = std::function<std::optional<std::string>(const std::string& id)>;

  /// `bound` in bytes as DeviceVolume counts them. With `stored` a copy of what the store no longer
  /// has is never given out, and forgotten by forget_outdated().
  VolumeCache(Load load, std::uint64_t bound, unsigned threads = 1, Stored stored = {});
  /// Waits for the load under way; those not begun end with kUnavailable.
  ~VolumeCache();
  VolumeCache(const VolumeCache&) = delete;
  VolumeCache& operator=(const VolumeCache&) = delete;

  /// Calls `ready` once: from within when the volume is there, else from a loading thread. A
  /// failure is told to all who waited and not remembered. kOutOfMemory: all that is loaded is
  /// being looked at and this one does not fit beside it.
  void get(const std::string& id, Ready ready);

  /// Forgets the copies of volumes that were deleted or replaced in the store (anonymised); which.
  /// Their memory is free once nobody holds them.
  std::vector<std::string> forget_outdated();

  /// Forgets what nobody holds, for who does not want to keep it for those who come back.
  void forget_unused();

  std::vector<std::string> loaded() const;
  std::uint64_t bytes() const;
  std::uint64_t loads() const;

 private:
  struct Entry {
    Handle volume;               // empty while loading
    std::uint64_t used = 0;      // turn of the last use
    std::vector<Ready> waiting;  // while loading
  };

  void work();
  Result<Handle> load_safely(const std::string& id);
  bool make_room(std::uint64_t needed);
  bool is_outdated(const std::string& id, const Handle& copy) const;
  bool forget(const std::string& id, const Handle& copy);

  const Load load_;
  const Stored stored_;
  const std::uint64_t bound_;
  mutable std::mutex mutex_;
  std::condition_variable work_ready_;
  std::map<std::string, Entry> entries_;
  std::deque<std::string> queue_;
  std::uint64_t turn_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t loads_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
