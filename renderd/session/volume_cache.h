#pragma once

#include <algorithm>
#include <compare>
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

/// A volume as it is shown: with or without what surrounds the body (volume::hide_surroundings),
/// and one of its phases.
struct VolumeKey {
  std::string id;
  bool with_table = false;
  std::uint32_t phase = 0;
  // clang-tidy 14 takes the zero of a generated comparison for a pointer.
  // NOLINTNEXTLINE(modernize-use-nullptr)
  auto operator<=>(const VolumeKey&) const = default;
};

/// Returns the phase of the scan that a scene shows: the last one if the scan has fewer.
inline std::uint32_t shown_phase(const diaphane::v1::Scene& scene, const volume::Header& header) {
  return std::min(scene.volume_phase(), header.phase_count() - 1);
}

/// The volumes on one device by their keys. Each is loaded once for all sessions and kept after the
/// last one left. When the limit is reached, the least recently used volumes are evicted, except
/// those that are in use. Loads in its own threads. Thread-safe.
class VolumeCache {
 public:
  using Handle = std::shared_ptr<const DeviceVolume>;
  using Load = std::function<Result<Handle>(const VolumeKey& key)>;
  using Ready = std::function<void(Result<Handle>)>;

  /// Returns the version (volume::version_of) of a volume in the store, or an empty string if the
  /// store does not have it. Returns nullopt if the store cannot answer, and then no copy counts as
  /// outdated.
  using Stored = std::function<std::optional<std::string>(const std::string& id)>;

  /// Limits the volumes to `bound` bytes as DeviceVolume counts them. With `stored`, copies that
  /// are no longer in the store are never returned, and forget_outdated() drops them.
  VolumeCache(Load load, std::uint64_t bound, unsigned threads = 1, Stored stored = {});
  /// Waits for the load in progress. Loads that have not begun end with kUnavailable.
  ~VolumeCache();
  VolumeCache(const VolumeCache&) = delete;
  VolumeCache& operator=(const VolumeCache&) = delete;

  /// Calls `ready` once: immediately if the volume is loaded, else from a loading thread. A failure
  /// is reported to all waiting callers and not remembered. Fails with kOutOfMemory if all loaded
  /// volumes are in use and this one does not fit beside them.
  void get(const VolumeKey& key, Ready ready);
  /// Returns a volume if it is loaded, otherwise null. Does not query the store, so it may return a
  /// copy that forget_outdated() is about to drop.
  Handle find(const VolumeKey& key);
  /// Returns whether `bytes` fit beside the volumes of other ids that are in use.
  bool fits(const std::string& id, std::uint64_t bytes) const;

  struct Outdated {
    std::string id;
    bool only_labels = false;  ///< the voxels are as in the store
  };
  /// Drops copies of volumes that were deleted or replaced in the store (anonymised), or whose
  /// labels were, and returns the ids. Their memory is freed once they are unused.
  std::vector<Outdated> forget_outdated();

  /// Drops all volumes that are not in use, for callers that do not need them kept.
  void forget_unused();

  std::vector<std::string> loaded() const;
  std::uint64_t bytes() const;
  std::uint64_t loads() const;

 private:
  struct Entry {
    Handle volume;               // null while loading
    std::uint64_t used = 0;      // sequence number of the last use
    std::vector<Ready> waiting;  // while loading
  };

  void work();
  Result<Handle> load_safely(const VolumeKey& key);
  bool make_room(std::uint64_t needed);
  bool is_outdated(const std::string& id, const Handle& copy) const;
  bool forget(const VolumeKey& key, const Handle& copy);

  const Load load_;
  const Stored stored_;
  const std::uint64_t bound_;
  mutable std::mutex mutex_;
  std::condition_variable work_ready_;
  std::map<VolumeKey, Entry> entries_;
  std::deque<VolumeKey> queue_;
  std::uint64_t turn_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t loads_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
