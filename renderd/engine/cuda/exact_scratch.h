#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>

#include "renderd/engine/cuda/exact_types.h"
#include "renderd/engine/cuda/memory.h"

namespace diaphane::render::cuda {

/// The properties of a scene that determine the memory of an item.
struct ExactNeeds {
  std::uint32_t light_strata = 0, indirect_strata = 0;  ///< maximum number of hits
  bool glow = false;                                    ///< Feature::kEmission

  std::uint32_t strata() const { return light_strata + indirect_strata; }
  std::uint64_t bytes() const {
    return sizeof(ExactItem) + sizeof(TileHits) + strata() * sizeof(HitRecord) +
           (glow ? light_strata * sizeof(Float4) : 0);
  }
};

/// Number of items per launch, enough to keep the device busy. The number of samples per launch,
/// and with it the exact bits of a picture, depends on this number, so it is a constant. An item
/// takes about 300 bytes.
inline constexpr std::uint64_t kExactItems = std::uint64_t{1} << 19;

/// The working memory of one launch of the exact walk, which only grows. Not thread-safe.
class ExactMemory {
 public:
  /// Works like ExactWorkspace::reserve().
  Result<std::uint64_t> reserve(const ExactNeeds& needs, std::uint64_t items, std::uint64_t least);
  /// Returns the number of items that fit.
  std::uint64_t room(const ExactNeeds& needs) const;
  ExactScratch scratch(const ExactNeeds& needs, std::uint64_t items) const;
  std::uint64_t bytes() const;

  /// Makes `stream` wait for the previous use of the memory.
  Result<void> take(cudaStream_t stream);
  Result<void> give(cudaStream_t stream);
  cudaStream_t last() const { return last_; }
  bool idle() const;

 private:
  Result<void> grow(const ExactNeeds& needs, std::uint64_t items);

  DeviceBuffer<ExactItem> items_;
  DeviceBuffer<TileHits> tiles_;
  DeviceBuffer<HitRecord> hits_;
  DeviceBuffer<Float4> glow_;
  DeviceBuffer<std::uint32_t> counters_;
  std::optional<Event> used_;  ///< recorded after the last use
  cudaStream_t last_ = nullptr;
};

/// The working memory of the exact walk for all sessions of a device, each of which has its own
/// stream. There are two memories, so that the camera rays of one session overlap with the last
/// light rays of another. A third memory serves urgent streams, which would otherwise wait behind
/// the queued work of other sessions.
class ExactWorkspace {
 public:
  using Launch = std::function<cudaError_t(const ExactScratch&)>;

  ExactWorkspace() { refused_.fill(std::numeric_limits<std::uint64_t>::max()); }

  /// Reserves memory for `items` items, or for at least `least` if memory is short. Leaves half of
  /// the free memory to pictures if it can. Returns the number of items, at most `items`.
  Result<std::uint64_t> reserve(const ExactNeeds& needs, std::uint64_t items, std::uint64_t least);

  /// Calls `launch`, which queues its work on `stream` after all previous work that used the same
  /// memory. `items` must not exceed the reserved number.
  Result<void> use(const ExactNeeds& needs, std::uint64_t items, cudaStream_t stream,
                   const Launch& launch);
  std::uint64_t device_bytes() const;

 private:
  ExactMemory& chosen(const ExactNeeds& needs, std::uint64_t items, cudaStream_t stream);

  mutable std::mutex mutex_;
  static constexpr std::size_t kSecond = 1, kUrgent = 2;
  bool serves(std::size_t memory, const ExactNeeds& needs, std::uint64_t items);

  std::array<ExactMemory, 3> memories_;   ///< all but the first are allocated on demand
  std::array<std::uint64_t, 3> refused_;  ///< number of items for which there was no memory
  std::uint64_t turns_ = 0;
};

}  // namespace diaphane::render::cuda
