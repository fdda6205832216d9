#pragma once

#include <cstdint>
#include <functional>
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

/// Working memory of the exact walk, one for all sessions of a device: they take turns on the
/// device, each in a stream of its own. Only grows, while there is a session.
class ExactWorkspace {
 public:
  using Launch = std::function<cudaError_t(const ExactScratch&)>;

  /// Makes room for `items`, and for no fewer than `least` where memory is short: for how many
  /// there is. Half of what is free is left to pictures. kOutOfMemory harms nothing.
  Result<std::uint64_t> reserve(const ExactNeeds& needs, std::uint64_t items, std::uint64_t least);

  /// Has `launch`, of no more items than were reserved, queue its work on `stream`, behind all that
  /// used the memory before.
  Result<void> use(const ExactNeeds& needs, std::uint64_t items, cudaStream_t stream,
                   const Launch& launch);
  std::uint64_t device_bytes() const;

 private:
  std::uint64_t room(const ExactNeeds& needs) const;
  Result<void> grow(const ExactNeeds& needs, std::uint64_t items);

  mutable std::mutex mutex_;
  DeviceBuffer<ExactItem> items_;
  DeviceBuffer<TileHits> tiles_;
  DeviceBuffer<HitRecord> hits_;
  DeviceBuffer<Float4> glow_;
  DeviceBuffer<std::uint32_t> counters_;
  std::optional<Event> used_;  ///< after the last use
};

}  // namespace diaphane::render::cuda
