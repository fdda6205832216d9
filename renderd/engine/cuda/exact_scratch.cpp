#include "renderd/engine/cuda/exact_scratch.h"

#include <algorithm>

#include "common/try.h"

namespace diaphane::render::cuda {
namespace {

std::uint64_t tiles_for(std::uint64_t items) { return (items + kTilePixels - 1) / kTilePixels; }

}  // namespace

std::uint64_t ExactMemory::room(const ExactNeeds& needs) const {
  if (counters_.data() == nullptr) return 0;
  std::uint64_t items = std::min<std::uint64_t>(items_.capacity(), kTilePixels * tiles_.capacity());
  items = std::min<std::uint64_t>(items, hits_.capacity() / needs.strata());
  if (needs.glow && needs.light_strata > 0) {
    items = std::min<std::uint64_t>(items, glow_.capacity() / needs.light_strata);
  }
  return items;
}

Result<void> ExactMemory::grow(const ExactNeeds& needs, std::uint64_t items) {
  if (!used_) {
    auto event = Event::make();
    DIAPHANE_TRY(event);
    used_ = std::move(*event);
  }
  DIAPHANE_TRY(ensure(counters_, kExactCounters));
  DIAPHANE_TRY(ensure(items_, items));
  DIAPHANE_TRY(ensure(tiles_, tiles_for(items)));
  DIAPHANE_TRY(ensure(hits_, items * needs.strata()));
  return needs.glow ? ensure(glow_, items * needs.light_strata) : Result<void>{};
}

Result<std::uint64_t> ExactMemory::reserve(const ExactNeeds& needs, std::uint64_t items,
                                           std::uint64_t least) {
  if (room(needs) >= items) return items;
  std::size_t free = 0, total = 0;
  DIAPHANE_CUDA_TRY(cudaMemGetInfo(&free, &total));
  for (std::uint64_t items_per_launch = std::min<std::uint64_t>(items, free / 2 / needs.bytes());;
       items_per_launch /= 2) {
    items_per_launch = std::max(items_per_launch, least);
    if (room(needs) >= items_per_launch) break;
    const auto grown = grow(needs, items_per_launch);
    if (grown) break;
    // Half as many items also work, with more launches per sample.
    if (grown.error().code != ErrorCode::kOutOfMemory || items_per_launch == least) {
      return tl::unexpected(grown.error());
    }
  }
  return std::min(room(needs), items);
}

ExactScratch ExactMemory::scratch(const ExactNeeds& needs, std::uint64_t items) const {
  return {.items = items_.data(),
          .tiles = tiles_.data(),
          .hits = hits_.data(),
          .glow = needs.glow ? glow_.data() : nullptr,
          .counters = counters_.data(),
          .indirect = static_cast<std::uint32_t>(items * needs.light_strata)};
}

std::uint64_t ExactMemory::bytes() const {
  return items_.bytes() + tiles_.bytes() + hits_.bytes() + glow_.bytes() + counters_.bytes();
}

Result<void> ExactMemory::take(cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(cudaStreamWaitEvent(stream, used_->get(), 0));
  return {};
}

Result<void> ExactMemory::give(cudaStream_t stream) {
  last_ = stream;
  DIAPHANE_CUDA_TRY(cudaEventRecord(used_->get(), stream));
  return {};
}

bool ExactMemory::idle() const { return !used_ || cudaEventQuery(used_->get()) == cudaSuccess; }

Result<std::uint64_t> ExactWorkspace::reserve(const ExactNeeds& needs, std::uint64_t items,
                                              std::uint64_t least) {
  const std::scoped_lock lock(mutex_);
  return memories_[0].reserve(needs, items, least);
}

// Returns whether a memory has enough room, after it tried to grow the memory if necessary.
bool ExactWorkspace::serves(std::size_t memory, const ExactNeeds& needs, std::uint64_t items) {
  if (memories_[memory].room(needs) >= items) return true;
  if (items >= refused_[memory]) return false;
  const auto grown = memories_[memory].reserve(needs, items, items);
  if (grown && *grown >= items) return true;
  refused_[memory] = items;
  return false;
}

// Returns the first memory if this stream used it last or if it is idle. Otherwise an urgent stream
// gets the urgent memory, and others get the second memory if it can be allocated. If the first and
// the second memory are busy, streams alternate between them.
ExactMemory& ExactWorkspace::chosen(const ExactNeeds& needs, std::uint64_t items,
                                    cudaStream_t stream) {
  auto& [first, second, urgent] = memories_;
  if (first.last() == stream || first.idle()) return first;
  int priority = 0;  // lower numbers are more urgent
  const bool hurries = cudaStreamGetPriority(stream, &priority) == cudaSuccess && priority < 0;
  if (hurries && serves(kUrgent, needs, items)) return urgent;
  if (!serves(kSecond, needs, items)) return first;
  if (second.last() == stream || second.idle()) return second;
  return (turns_++ & 1) != 0 ? second : first;
}

Result<void> ExactWorkspace::use(const ExactNeeds& needs, std::uint64_t items, cudaStream_t stream,
                                 const Launch& launch) {
  const std::scoped_lock lock(mutex_);
  ExactMemory& memory = chosen(needs, items, stream);
  DIAPHANE_TRY(memory.take(stream));
  DIAPHANE_CUDA_TRY(launch(memory.scratch(needs, items)));
  return memory.give(stream);
}

std::uint64_t ExactWorkspace::device_bytes() const {
  const std::scoped_lock lock(mutex_);
  std::uint64_t bytes = 0;
  for (const ExactMemory& memory : memories_) bytes += memory.bytes();
  return bytes;
}

}  // namespace diaphane::render::cuda
