#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>

#include "renderd/engine/cuda_exact_types.h"
#include "renderd/engine/cuda_memory.h"

namespace diaphane::render::cuda {

/// What an item needs room for.
struct ExactNeeds {
  std::uint32_t light_strata = 0, onwards_strata = 0;  ///< hits at most
  bool glow = false;                                   ///< Feature::kEmission

  std::uint32_t strata() const { return light_strata + onwards_strata; }
  std::uint64_t bytes() const {
    return sizeof(ExactItem) + sizeof(TileHits) + strata() * sizeof(HitRecord) +
           (glow ? light_strata * sizeof(Float4) : 0);
  }
};

/// Items of a launch: enough to keep the device busy. How many samples a launch takes depends on
/// it, and so the bits of a picture: a constant. Some 300 bytes each.
inline constexpr std::uint64_t kExactItems = std::uint64_t{1} << 19;

/// Working memory of one launch of the exact walk. Not thread-safe. Only grows.
class ExactMemory {
 public:
  /// As ExactWorkspace::reserve().
  Result<std::uint64_t> reserve(const ExactNeeds& needs, std::uint64_t items, std::uint64_t least);
  /// Items that there is room for.
  std::uint64_t room(const ExactNeeds& needs) const;
  ExactScratch scratch(const ExactNeeds& needs, std::uint64_t items) const;
  std::uint64_t bytes() const;

  /// `stream` goes on once what used the memory before has ended.
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
  std::optional<Event> used_;  ///< after the last use
  cudaStream_t last_ = nullptr;
};

/// Working memory of the exact walk for all sessions of a device, each in a stream of its own.
/// There are two, so that one session's camera rays are walked while another's last rays to the
/// lights are; and one for urgent streams, which would else wait behind what the others have
/// queued.
class ExactWorkspace {
 public:
  using Launch = std::function<cudaError_t(const ExactScratch&)>;

  ExactWorkspace() { refused_.fill(std::numeric_limits<std::uint64_t>::max()); }

  /// Makes room for `items`, and for no fewer than `least` where memory is short: for how many
  /// there is. Half of what is free is left to pictures. kOutOfMemory harms nothing.
  Result<std::uint64_t> reserve(const ExactNeeds& needs, std::uint64_t items, std::uint64_t least);

  /// Has `launch`, of no more items than were reserved, queue its work on `stream`, behind all that
  /// used the same memory before.
  Result<void> use(const ExactNeeds& needs, std::uint64_t items, cudaStream_t stream,
                   const Launch& launch);
  std::uint64_t device_bytes() const;

 private:
  ExactMemory& chosen(const ExactNeeds& needs, std::uint64_t items, cudaStream_t stream);

  mutable std::mutex mutex_;
  static constexpr std::size_t kSecond = 1, kUrgent = 2;
  bool serves(std::size_t memory, const ExactNeeds& needs, std::uint64_t items);

  std::array<ExactMemory, 3> memories_;   ///< all but the first only once they are of use
  std::array<std::uint64_t, 3> refused_;  ///< items that there was no memory for
  std::uint64_t turns_ = 0;
};

}  // namespace diaphane::render::cuda
