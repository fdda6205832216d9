#include <utility>

#include "renderd/encode/slice_codec.h"
#include "renderd/serve/session_turn.h"
#include "renderd/session/kept_voxels.h"

// LiveSession: reads and encodes the exact slices beside the picture (docs/adr/0026).

namespace diaphane::render {
namespace {

Result<std::vector<std::int16_t>> read_slice(const volume::Volume& volume,
                                             const volume::SliceStack& stack, const SliceDue& due,
                                             const std::optional<v1::Clip>& clip) {
  if (!clip) {
    return due.oblique ? volume::sample(volume, *due.oblique)
                       : volume::slice_of(volume, stack, due.index);
  }
  const volume::KeptVoxels kept = kept_by(volume.header, *clip);
  return due.oblique ? volume::sample_clipped(volume, *due.oblique, kept)
                     : volume::clipped_slice_of(volume, stack, due.index, kept);
}

}  // namespace

void LiveSession::carry_out(const effect::LoadVoxels& effect) {
  // Posted, because the cache may read from the store.
  parts_.slices.pool.post(
      EncodePool::Urgency::kNow, [weak = weak_from_this(), phase = effect.phase] {
        const auto session = weak.lock();
        if (!session) return;
        session->parts_.slices.voxels.get({session->facts_.volume_id, false, phase},
                                          [weak](Result<VolumeCache::Handle> loaded) {
                                            if (const auto alive = weak.lock())
                                              alive->voxels_ready(std::move(loaded));
                                          });
      });
}

void LiveSession::voxels_ready(Result<VolumeCache::Handle> loaded) {
  const Turn turn(*this);
  if (ended_) return;
  apply(slices_.handle(VoxelsLoaded{std::move(loaded), volume_->header().content_hash}, state_,
                       turn.now));
}

void LiveSession::carry_out(effect::CodeSlice& effect) {
  const auto urgency =
      effect.for_guest || visitor_ ? EncodePool::Urgency::kLater : EncodePool::Urgency::kNow;
  parts_.slices.pool.post(urgency, [weak = weak_from_this(), effect = std::move(effect)] {
    if (weak.expired()) return;
    const SliceOrder& order = effect.order;
    auto coded = read_slice(effect.voxels->volume(), effect.stack, order.due, order.clip)
                     .and_then([](const auto& values) { return code_slice(values); });
    if (const auto session = weak.lock()) {
      session->slice_coded(effect.connection, order, std::move(coded));
    }
  });
}

void LiveSession::slice_coded(std::uint64_t connection, SliceOrder order,
                              Result<std::string> coded) {
  const Turn turn(*this);
  apply(
      slices_.handle(SliceCoded{connection, std::move(order), std::move(coded)}, state_, turn.now));
}

}  // namespace diaphane::render
