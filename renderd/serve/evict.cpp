#include "renderd/serve/evict.h"

#include <tuple>

namespace diaphane::render {
namespace {

enum class Rank { kAbandonedVisitor, kFreeCamera, kVisitor, kAbandoned, kStays };

Rank rank_of(const SlotHolder& holder) {
  if (holder.visitor && holder.abandoned_for) return Rank::kAbandonedVisitor;
  if (holder.visitor) return holder.free_camera ? Rank::kFreeCamera : Rank::kVisitor;
  return holder.abandoned_for ? Rank::kAbandoned : Rank::kStays;
}

/// Returns a key that sorts the holder to evict first to the front.
auto order_of(const SlotHolder& holder) {
  return std::tuple(rank_of(holder), -holder.abandoned_for.value_or(holder.age));
}

}  // namespace

std::optional<std::string> to_evict(std::span<const SlotHolder> holders, bool for_visitor) {
  const SlotHolder* first = nullptr;
  for (const SlotHolder& holder : holders) {
    const Rank rank = rank_of(holder);
    if (rank == Rank::kStays || (for_visitor && rank != Rank::kAbandonedVisitor)) continue;
    if (!first || order_of(holder) < order_of(*first)) first = &holder;
  }
  if (!first) return std::nullopt;
  return first->id;
}

}  // namespace diaphane::render
